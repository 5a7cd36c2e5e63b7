"""Opens files in the page of their type: dropped, chosen in the menu, or named on the command line."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from PySide6.QtCore import QEvent, QMimeData, QObject
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import QMenu, QWidget

from app.text.i18n import tr
from app.text.visible_text import visible
from ui.core.preferences import Preferences
from ui.files.file_dialogs import ThenPath, ask_open
from ui.widgets.controls import named


class FilePage(NamedTuple):
    """The key of a page, the suffixes of its files, and how it opens one."""

    key: str
    suffixes: tuple[str, ...]
    open_file: Callable[[Path], None]


def add_recent(menu: QMenu, prefix: str, names: Iterable[str], open_file: Callable[[Path], object]) -> None:
    """Adds an entry for each of these files to `menu`."""
    for number, name in enumerate(names):
        action = named(menu.addAction(visible(Path(name).name).replace("&", "&&")), f"{prefix}_{number}")
        action.setToolTip(visible(name))
        action.triggered.connect(lambda _checked, path=Path(name): open_file(path))


class FileOpener(QObject):
    """`pages` returns the pages that open files; `go_to` shows a page; `say` shows a line."""

    def __init__(
        self,
        window: QWidget,
        pages: Callable[[], list[FilePage]],
        go_to: Callable[[str], None],
        *,
        preferences: Preferences,
        say: Callable[[str], None],
    ) -> None:
        super().__init__(window)
        self._window, self._pages, self._go_to = window, pages, go_to
        self._preferences, self.say = preferences, say
        self.choose: Callable[[QWidget, Path, str, str, ThenPath], object] = ask_open
        window.setAcceptDrops(True)
        window.installEventFilter(self)

    def open(self, path: Path) -> bool:
        """Opens a file in the page of its type; returns whether it does."""
        page = self._page_of(path)
        if page is None:
            self.say(tr("No page opens {file}.", file=visible(path.name)))
            return False
        if path.exists() and not (path.is_file() or path.is_dir()):  # opening a pipe or a device may block
            why = tr("unknown kind of file")
            self.say(tr("{file} cannot be read: {why}.", file=visible(path.name), why=why))
            return False
        self._go_to(page.key)
        page.open_file(path)
        self._preferences.add_file(path)
        return True

    def open_in(self, key: str, paths: Iterable[Path]) -> None:
        """Shows a page; opens folders in it, and files in the page of their type, this one first."""
        self._go_to(key)
        for path in paths:
            page = next((page for page in self._pages() if page.key == key), None)
            if page is not None and path.is_dir():
                page.open_file(path)
            else:
                self.open(path)

    def ask(self) -> None:
        """Lets the user choose a file, and opens it."""
        endings = " ".join(f"*{suffix}" for page in self._pages() for suffix in page.suffixes)
        recent = self._preferences.recent_files
        folder = Path(recent[0]).parent if recent else Path.home()
        self.choose(self._window, folder, tr("Open…"), f"{tr('Files of this program')} ({endings})", self.open)

    def fill(self, menu: QMenu) -> None:
        """Fills `menu` with the recent files."""
        menu.clear()
        add_recent(menu, "act_recent", self._preferences.recent_files, self.open)
        if not self._preferences.recent_files:
            menu.addAction(tr("No recent files")).setEnabled(False)

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        if isinstance(event, QDragEnterEvent) and self._found(event.mimeData()) is not None:
            event.acceptProposedAction()
            return True
        if isinstance(event, QDropEvent) and event.type() == QEvent.Type.Drop:
            path = self._found(event.mimeData())
            if path is not None:
                event.acceptProposedAction()
                return self.open(path)
        return False

    def _page_of(self, path: Path) -> FilePage | None:
        return next((page for page in self._pages() if path.suffix.lower() in page.suffixes), None)

    def _found(self, data: QMimeData) -> Path | None:
        """The first file that some page opens."""
        paths = (Path(url.toLocalFile()) for url in data.urls() if url.isLocalFile())
        return next((path for path in paths if self._page_of(path) is not None), None)
