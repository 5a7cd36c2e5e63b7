"""File dialogs and suggested file names."""

from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path
from typing import Final

from PySide6.QtWidgets import QFileDialog, QWidget

from app.text.i18n import tr

MAX_PORT_LENGTH: Final = 40
"""Characters of a port in a file name; with up to four bytes each they fit into the 255 bytes of a name."""
AskPath = Callable[[QWidget, str, Path, str], Path | None]
"""Parent, title, suggested path, filter; None if cancelled."""
AskOpen = Callable[[QWidget, Path], Path | None]
"""Parent and folder; None if cancelled."""
AskMany = Callable[[QWidget, Path], Sequence[Path]]
"""Parent and folder; empty if cancelled."""


def ask_open(parent: QWidget, folder: Path, title: str, name_filter: str) -> Path | None:
    """Lets the user choose an existing file; None if cancelled."""
    name, _filter = QFileDialog.getOpenFileName(parent, title.rstrip("…"), str(folder), name_filter)
    return Path(name) if name else None


def ask_flight_logs(parent: QWidget, folder: Path) -> Sequence[Path]:
    """Existing files, one or many."""
    kinds = tr("Flight logs (*.ulg *.bin *.csv *.mcap)")
    names, _filter = QFileDialog.getOpenFileNames(parent, tr("Open flight logs"), str(folder), kinds)
    return [Path(name) for name in names]


def ask_folder(parent: QWidget, folder: Path) -> Sequence[Path]:
    """One existing folder."""
    name = QFileDialog.getExistingDirectory(parent, tr("Open flight logs"), str(folder))
    return [Path(name)] if name else []


def ask_profile(parent: QWidget, folder: Path) -> Path | None:
    return ask_open(parent, folder, tr("Open profile…"), tr("Profile (*.toml)"))


def ask_path(parent: QWidget, title: str, suggested: Path, name_filter: str) -> Path | None:
    """Lets the user choose where to save, and confirms replacing a file; None if cancelled."""
    dialog = QFileDialog(parent, title.rstrip("…"), str(suggested.parent), name_filter)
    dialog.setObjectName("save_dialog")
    dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
    dialog.setDefaultSuffix(suggested.suffix.lstrip("."))
    dialog.selectFile(suggested.name)
    try:
        chosen = dialog.selectedFiles() if dialog.exec() else []
    finally:
        dialog.deleteLater()
    return Path(chosen[0]) if chosen else None


def default_name(port: str, suffix: str, when: datetime) -> str:
    """A file name such as "dps-s ttyUSB0 2026-11-21 09-30-05.csv", in characters that every system accepts."""
    short = port.removeprefix("/dev/").partition("?")[0].replace("://", "-")
    safe = "".join(one if one.isalnum() or one in "-_." else "-" for one in short[:MAX_PORT_LENGTH])
    return " ".join(part for part in ("dps-s", safe, f"{when:%Y-%m-%d %H-%M-%S}") if part) + suffix
