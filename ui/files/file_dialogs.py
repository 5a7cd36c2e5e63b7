"""Dialogs that ask for a file or a name, suggested file names, and the page that opens a file.

A dialog never renames, moves or removes a file: each is Qt's own (`ui/main.py` sees to it) and read-only. That takes
Qt's "New Folder" away, so a dialog that saves has one of ours.

`open_dialog` is the one way to ask in a dialog: it returns at once and calls `then` when the dialog was accepted.
Nothing is modal, nothing waits in an event loop of its own, and what is asked for is what it was when it opened.
"""

from collections.abc import Callable, Iterable, Sequence
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Final

from PySide6.QtCore import QEvent, QObject, QPoint, QSize, Qt
from PySide6.QtGui import QDropEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QDialog,
    QFileDialog,
    QHBoxLayout,
    QInputDialog,
    QLabel,
    QMenu,
    QMessageBox,
    QToolButton,
    QWidget,
)

from app.text.i18n import tr
from app.text.messages import UserError, error_text, visible
from protocol.translatable import marked
from ui.core.preferences import Preferences
from ui.style.icons import Icon, icon, set_icon_size
from ui.style.theme import IconSize
from ui.widgets.controls import named, without_key

if TYPE_CHECKING:
    from ui.services.page import Page

# The most that a system puts above a dialog, and beside its title.
_TITLE_BAR_PX: Final = 36
_TITLE_BUTTONS_PX: Final = 160
# The key of the page that says of any file why it cannot be read, and the kinds of its files.
LOGS: Final = "logs"
_LOGS: Final = "*.ulg *.bin *.log *.tlog *.csv *.tsv *.txt *.mcap *.gz *.zip"
# Called with what was chosen; not at all where the dialog was cancelled.
ThenPath = Callable[[Path], object]
ThenPaths = Callable[[Sequence[Path]], object]
# Parent, title, suggested path, filter; parent and folder; parent, title, label.
AskPath = Callable[[QWidget, str, Path, str, ThenPath], object]
AskOpen = Callable[[QWidget, Path, ThenPath], object]
AskMany = Callable[[QWidget, Path, ThenPaths], object]
AskText = Callable[[QWidget, str, str, Callable[[str], object]], object]


def open_dialog(dialog: QDialog, name: str, then: Callable[[], object], *, is_large: bool = False) -> None:
    """Shows `dialog`, which is deleted when it closes, in place of an open one of the same name. It blocks nothing."""
    for other in (dialog.parentWidget() or dialog).window().findChildren(QDialog, name):
        other.reject()
    named(dialog, name)
    dialog.setAccessibleName(dialog.windowTitle())
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.setModal(False)
    dialog.accepted.connect(then)
    show_over_page(dialog, is_large=is_large)


def show_over_page(dialog: QDialog, *, is_large: bool = False) -> None:
    """Shows `dialog` in front of the page, and no larger, so that it covers no LOCK; also where it was minimised.

    `is_large`: as large as it may be, else as its contents need.
    """
    if not dialog.isVisible():
        window = (dialog.parentWidget() or dialog).window()
        page = window.findChild(QWidget, "centre") or window
        largest = QSize(round(page.width() * 0.8), page.height() - _TITLE_BAR_PX)
        dialog.adjustSize()
        title_px = dialog.fontMetrics().horizontalAdvance(dialog.windowTitle()) + _TITLE_BUTTONS_PX
        dialog.resize(dialog.size().expandedTo(QSize(title_px, 0)))  # no title is elided
        dialog.resize(largest if is_large else dialog.size().boundedTo(largest))
        dialog.show()  # its style may make it larger
        spare = page.size() - dialog.size() - QSize(0, _TITLE_BAR_PX)
        dialog.move(page.mapToGlobal(QPoint(max(0, spare.width() // 2), max(0, spare.height() // 2))))
    dialog.setWindowState(dialog.windowState() & ~Qt.WindowState.WindowMinimized)
    dialog.raise_()
    dialog.activateWindow()


class _FileDialog(QFileDialog):
    """Asks and says without blocking anything what Qt's own would in modal dialogs."""

    asks_before_replacing = True
    # Where a file was saved last, by any page; none yet.
    last_folder: ClassVar[Path | None] = None

    def accept(self) -> None:
        paths = [Path(one) for one in self.selectedFiles()]
        is_saving = self.acceptMode() is QFileDialog.AcceptMode.AcceptSave
        missing = next((path for path in paths if not path.exists()), None)
        buttons = QMessageBox.StandardButton
        if is_saving and self.asks_before_replacing and paths and paths[0].is_file():
            text = tr("{file} exists. Replace it?", file=visible(paths[0].name))
            self._say(text, buttons.Yes | buttons.No, partial(QFileDialog.accept, self))
        elif not is_saving and missing is not None:
            self._say(tr("There is no {file} here.", file=visible(missing.name)), buttons.Ok, bool)
        else:
            super().accept()

    def _say(self, text: str, buttons: QMessageBox.StandardButton, then: Callable[[], object]) -> None:
        box = QMessageBox(QMessageBox.Icon.Warning, self.windowTitle(), text, buttons, self)
        box.setDefaultButton(QMessageBox.StandardButton.No)
        open_dialog(box, "file_message", then)


def _dialog(parent: QWidget, title: str, folder: Path, kinds: str, mode: QFileDialog.FileMode) -> _FileDialog:
    dialog = _FileDialog(parent, title.rstrip("…"), str(folder), kinds)
    dialog.setFileMode(mode)
    dialog.setOption(QFileDialog.Option.ReadOnly)
    dialog.setOption(QFileDialog.Option.DontConfirmOverwrite)
    for view in dialog.findChildren(QAbstractItemView):  # a drag to a file manager could move the file
        view.setDragDropMode(QAbstractItemView.DragDropMode.NoDragDrop)
    _folder_button(dialog).hide()
    dialog.setLabelText(QFileDialog.DialogLabel.LookIn, tr("Folder"))  # Qt has no Chinese for these two
    dialog.setLabelText(QFileDialog.DialogLabel.FileType, tr("Files"))
    # Qt's own are black in the dark theme, too.
    arrows = {"backButton": Icon.CHEVRON_LEFT, "forwardButton": Icon.CHEVRON_RIGHT, "toParentButton": Icon.CHEVRON_UP}
    for button in dialog.findChildren(QToolButton):
        if button.objectName() in arrows:
            button.setIcon(icon(arrows[button.objectName()]))
    return dialog


def _folder_button(dialog: QFileDialog) -> QToolButton:
    """Qt's "New Folder", which a read-only dialog never enables."""
    button = dialog.findChild(QToolButton, "newFolderButton")
    if not isinstance(button, QToolButton):
        raise TypeError("the dialog is not Qt's own")
    return button


def _ask_folder_name(dialog: QFileDialog, label: str, name: str) -> None:
    """Makes a folder where the dialog is, and goes there; a name that does not do is asked for again."""

    def make(name: str) -> None:
        parent = Path(dialog.directory().absolutePath())
        try:
            if not name.strip() or name in (".", "..") or Path(name).name != name:
                raise ValueError(name)
            (parent / name).mkdir()  # raises ValueError, too, for what no name on this system can hold
        except (OSError, ValueError) as error:
            known = error if isinstance(error, OSError) else UserError(marked("this name is not possible"))
            why = tr("{folder} cannot be made: {why}.", folder=visible(name), why=error_text(known))
            _ask_folder_name(dialog, why, name)
        else:
            dialog.setDirectory(str(parent / name))

    ask_text(dialog, tr("New folder…"), label, make, text=name)


def _open_file_dialog(dialog: QFileDialog, then: ThenPaths) -> None:
    name = "save_dialog" if dialog.acceptMode() is QFileDialog.AcceptMode.AcceptSave else "open_dialog"
    open_dialog(dialog, name, lambda: then([Path(chosen) for chosen in dialog.selectedFiles()]), is_large=True)


def ask_open(parent: QWidget, folder: Path, title: str, name_filter: str, then: ThenPath) -> None:
    dialog = _dialog(parent, title, folder, name_filter, QFileDialog.FileMode.ExistingFile)
    _open_file_dialog(dialog, lambda paths: then(paths[0]))


def ask_profile(parent: QWidget, folder: Path, then: ThenPath) -> None:
    ask_open(parent, folder, tr("Open profile…"), "*.toml", then)


def ask_flight_logs(parent: QWidget, folder: Path, then: ThenPaths) -> None:
    _open_file_dialog(_dialog(parent, tr("Open…"), folder, _LOGS, QFileDialog.FileMode.ExistingFiles), then)


def ask_folder(parent: QWidget, folder: Path, then: ThenPaths) -> None:
    dialog = _dialog(parent, tr("Open…"), folder, "", QFileDialog.FileMode.Directory)
    dialog.setOption(QFileDialog.Option.ShowDirsOnly)
    _open_file_dialog(dialog, then)


def ask_path(
    parent: QWidget, title: str, suggested: Path, name_filter: str, then: ThenPath, *, is_extended: bool = False
) -> None:
    """Lets the user choose where to save, and confirms replacing a file. A name alone is suggested in the folder of the
    file that was saved last. `is_extended`: an existing file is not replaced, so there is nothing to confirm."""
    folder = suggested.parent if suggested.is_absolute() else _FileDialog.last_folder or Path.home()
    dialog = _dialog(parent, title, folder, name_filter, QFileDialog.FileMode.AnyFile)
    dialog.setDefaultSuffix(suggested.suffix.lstrip("."))
    dialog.asks_before_replacing = not is_extended
    dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
    dialog.selectFile(suggested.name)
    # A button of ours in the place of Qt's.
    theirs, button = _folder_button(dialog), named(QToolButton(), "new_folder")
    button.setIcon(icon(Icon.FOLDER_NEW))
    set_icon_size(button, IconSize.TEXT)
    button.setAccessibleName(tr("New folder…"))
    button.setToolTip(tr("New folder…"))
    button.setAutoRaise(theirs.autoRaise())
    button.clicked.connect(lambda: _ask_folder_name(dialog, tr("Name of the new folder"), ""))
    row = next(row for row in dialog.findChildren(QHBoxLayout) if row.indexOf(theirs) >= 0)
    row.insertWidget(row.indexOf(theirs), button)

    def end(paths: Sequence[Path]) -> None:
        _FileDialog.last_folder = paths[0].parent
        then(paths[0])

    _open_file_dialog(dialog, end)


def ask_text(parent: QWidget, title: str, label: str, then: Callable[[str], object], *, text: str = "") -> None:
    """`text` is what stands in the field at first."""
    dialog = QInputDialog(parent)
    dialog.setWindowTitle(title.rstrip("…"))
    dialog.setLabelText(label)
    dialog.setTextValue(text)
    for part in dialog.findChildren(QLabel):
        part.setWordWrap(True)
    open_dialog(dialog, "text_dialog", lambda: then(dialog.textValue()))


def default_name(port: str, suffix: str, when: datetime) -> str:
    """A file name such as "dps-s ttyUSB0 2026-11-21 09-30-05.csv", in characters that every system accepts."""
    # 40 characters of up to four bytes each fit into the 255 bytes of a name.
    short = port.removeprefix("/dev/").partition("?")[0].replace("://", "-")[:40]
    safe = "".join(character if character.isalnum() or character in "-_." else "-" for character in short)
    return " ".join(part for part in ("dps-s", safe, f"{when:%Y-%m-%d %H-%M-%S}") if part) + suffix


def add_recent(menu: QMenu, prefix: str, names: Iterable[str], open_file: Callable[[Path], object]) -> None:
    for number, name in enumerate(names):
        action = named(menu.addAction(without_key(visible(Path(name).name))), f"{prefix}_{number}")
        action.setToolTip(visible(name))
        action.triggered.connect(lambda _checked, path=Path(name): open_file(path))


class FileOpener(QObject):
    """Opens files from the menu, the command line or a drop on the window in the page of their type. `pages`: all
    of the window, by their keys; `go_to` shows one."""

    def __init__(
        self,
        window: QWidget,
        pages: "dict[str, Page]",
        go_to: Callable[[str], None],
        *,
        preferences: Preferences,
    ) -> None:
        super().__init__(window)
        self._window, self._pages, self._go_to, self._preferences = window, pages, go_to, preferences
        self.choose: Callable[[QWidget, Path, str, str, ThenPath], object] = ask_open
        window.installEventFilter(self)

    def open(self, *paths: Path) -> None:
        """Opens each file in the page of its type, and what is of none in Logs, which says why it cannot be read."""
        files: dict[str, list[Path]] = {}
        for path in paths:
            key = next((key for key, page in self._pages.items() if path.suffix.lower() in page.suffixes), LOGS)
            files.setdefault(key, []).append(path)
        for key, together in files.items():
            self._go_to(key)
            if key in self._pages:
                self._pages[key].open_files(together)
        self._preferences.files_folder = str(paths[0].absolute().parent)

    def ask(self) -> None:
        endings = " ".join(f"*{suffix}" for page in self._pages.values() for suffix in page.suffixes)
        folder = Path(self._preferences.files_folder or Path.home())
        self.choose(self._window, folder, tr("Open…"), endings, self.open)

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        if not isinstance(event, QDropEvent) or event.type() not in (QEvent.Type.DragEnter, QEvent.Type.Drop):
            return False
        paths = [Path(url.toLocalFile()) for url in event.mimeData().urls() if url.isLocalFile()]
        if paths:
            event.acceptProposedAction()
            if event.type() is QEvent.Type.Drop:
                self.open(*paths)
        return bool(paths)
