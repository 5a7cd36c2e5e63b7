"""Routes dropped files to the page that opens their type."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from PySide6.QtCore import QEvent, QMimeData, QObject
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import QWidget


class FilePage(NamedTuple):
    """A page's key, and what it does with a file."""

    key: str
    open_file: Callable[[Path], None]


class FileDrops(QObject):
    """`find_page` gives the page for a suffix such as ".toml"; `go_to` brings it into sight."""

    def __init__(
        self, window: QWidget, find_page: Callable[[str], FilePage | None], go_to: Callable[[str], None]
    ) -> None:
        super().__init__(window)
        self._find_page, self._go_to = find_page, go_to
        window.setAcceptDrops(True)
        window.installEventFilter(self)

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        if isinstance(event, QDragEnterEvent) and self._found(event.mimeData()) is not None:
            event.acceptProposedAction()
            return True
        if isinstance(event, QDropEvent) and event.type() == QEvent.Type.Drop:
            path = self._found(event.mimeData())
            page = None if path is None else self._find_page(path.suffix.lower())
            if path is not None and page is not None:
                event.acceptProposedAction()
                self._go_to(page.key)
                page.open_file(path)
                return True
        return False

    def _found(self, data: QMimeData) -> Path | None:
        """The first file that some page takes."""
        paths = (Path(url.toLocalFile()) for url in data.urls() if url.isLocalFile())
        return next((path for path in paths if self._find_page(path.suffix.lower()) is not None), None)
