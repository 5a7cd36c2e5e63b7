"""Dialogs that ask for a file or a name, and suggested file names.

`open_dialog` is the one way to show a modal dialog: it returns at once and calls `then` when the dialog was accepted.
Nothing waits in an event loop of its own, and what is asked for is what it was when the dialog opened.
"""

from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QFileDialog, QInputDialog, QWidget

from app.text.i18n import tr
from ui.widgets.controls import named

MAX_PORT_LENGTH: Final = 40
"""Characters of a port in a file name; with up to four bytes each they fit into the 255 bytes of a name."""
ThenPath = Callable[[Path], object]
"""Called with what was chosen; not at all where the dialog was cancelled."""
ThenPaths = Callable[[Sequence[Path]], object]
AskPath = Callable[[QWidget, str, Path, str, ThenPath], object]
"""Parent, title, suggested path, filter."""
AskOpen = Callable[[QWidget, Path, ThenPath], object]
"""Parent and folder."""
AskMany = Callable[[QWidget, Path, ThenPaths], object]
"""Parent and folder."""
AskText = Callable[[QWidget, str, str, Callable[[str], object]], object]
"""Parent, title, label."""


def open_dialog(dialog: QDialog, name: str, then: Callable[[], object]) -> None:
    """Shows `dialog`, which is deleted when it closes. It blocks the window that it belongs to, and nothing else."""
    named(dialog, name)
    dialog.setAccessibleName(dialog.windowTitle())
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.setWindowModality(Qt.WindowModality.WindowModal)
    dialog.accepted.connect(then)
    dialog.open()


def _open_file_dialog(
    dialog: QFileDialog, name: str, mode: QFileDialog.FileMode, then: ThenPaths, accept: QFileDialog.AcceptMode
) -> None:
    dialog.setAcceptMode(accept)
    dialog.setFileMode(mode)
    open_dialog(dialog, name, lambda: then([Path(chosen) for chosen in dialog.selectedFiles()]))


def _ask_existing(
    parent: QWidget, folder: Path, title: str, name_filter: str, mode: QFileDialog.FileMode, then: ThenPaths
) -> None:
    dialog = QFileDialog(parent, title.rstrip("…"), str(folder), name_filter)
    _open_file_dialog(dialog, "open_dialog", mode, then, QFileDialog.AcceptMode.AcceptOpen)


def ask_open(parent: QWidget, folder: Path, title: str, name_filter: str, then: ThenPath) -> None:
    """Lets the user choose an existing file."""
    _ask_existing(parent, folder, title, name_filter, QFileDialog.FileMode.ExistingFile, lambda paths: then(paths[0]))


def ask_flight_logs(parent: QWidget, folder: Path, then: ThenPaths) -> None:
    """Existing files, one or many."""
    kinds = tr("Flight logs (*.ulg *.bin *.csv *.mcap)")
    _ask_existing(parent, folder, tr("Open flight logs"), kinds, QFileDialog.FileMode.ExistingFiles, then)


def ask_folder(parent: QWidget, folder: Path, then: ThenPaths) -> None:
    """One existing folder."""
    dialog = QFileDialog(parent, tr("Open flight logs"), str(folder))
    dialog.setOption(QFileDialog.Option.ShowDirsOnly)
    _open_file_dialog(dialog, "open_dialog", QFileDialog.FileMode.Directory, then, QFileDialog.AcceptMode.AcceptOpen)


def ask_profile(parent: QWidget, folder: Path, then: ThenPath) -> None:
    ask_open(parent, folder, tr("Open profile…"), tr("Profile (*.toml)"), then)


def ask_path(
    parent: QWidget, title: str, suggested: Path, name_filter: str, then: ThenPath, *, is_extended: bool = False
) -> None:
    """Lets the user choose where to save, and confirms replacing a file. `is_extended`: an existing file is not
    replaced, so there is nothing to confirm."""
    dialog = QFileDialog(parent, title.rstrip("…"), str(suggested.parent), name_filter)
    dialog.setDefaultSuffix(suggested.suffix.lstrip("."))
    dialog.setOption(QFileDialog.Option.DontConfirmOverwrite, is_extended)
    dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
    dialog.selectFile(suggested.name)
    _open_file_dialog(
        dialog, "save_dialog", QFileDialog.FileMode.AnyFile, lambda paths: then(paths[0]),
        QFileDialog.AcceptMode.AcceptSave,
    )  # fmt: skip


def ask_text(parent: QWidget, title: str, label: str, then: Callable[[str], object]) -> None:
    """Lets the user enter a line of text."""
    dialog = QInputDialog(parent)
    dialog.setWindowTitle(title.rstrip("…"))
    dialog.setLabelText(label)
    open_dialog(dialog, "text_dialog", lambda: then(dialog.textValue()))


def default_name(port: str, suffix: str, when: datetime) -> str:
    """A file name such as "dps-s ttyUSB0 2026-11-21 09-30-05.csv", in characters that every system accepts."""
    short = port.removeprefix("/dev/").partition("?")[0].replace("://", "-")
    safe = "".join(one if one.isalnum() or one in "-_." else "-" for one in short[:MAX_PORT_LENGTH])
    return " ".join(part for part in ("dps-s", safe, f"{when:%Y-%m-%d %H-%M-%S}") if part) + suffix
