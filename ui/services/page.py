"""The base class of the window's pages."""

from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAccessible, QAction, QHideEvent, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QWidget

from app.engine.worker import Batch
from ui.core.texts import Texts
from ui.services.job_notice import JobNotice
from ui.services.page_header import PageHeader
from ui.widgets.visibility_timer import VisibilityTimer


class Page(QWidget):
    """What it polls while it is seen, and what follows language and theme: see `VisibilityTimer`."""

    accessible_role: ClassVar = QAccessible.Role.Section
    connect_wanted = Signal(object)
    """To this `Target`; the window asks first where that is risky."""
    ports_wanted = Signal()
    """To choose one."""
    page_wanted = Signal(str)
    """The key of a page."""
    shows_link: bool = False
    """The page itself says that nothing is connected, and leads on."""
    saving: QAction | None = None
    """What "Save…" of the file menu does on this page; `exporting`: "Export…"."""
    exporting: QAction | None = None
    suffixes: tuple[str, ...] = ()
    """Of the files that may be dropped on the window for this page."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self.setObjectName(f"{name}_page")
        self.covered_px: Callable[[], int] = int
        """How much of the left lies under the list of ports."""
        VisibilityTimer(self, restyle=self.fit)

    @property
    def key(self) -> str:
        """In the navigation."""
        return self.objectName().removesuffix("_page")

    def make_header(self, texts: Texts, title: str, *actions: QWidget) -> PageHeader:
        """The first row of the page; `title` is English, marked."""
        return PageHeader(self.key, texts, title, *actions)

    def open_file(self, path: Path) -> None:
        """A file of one of `suffixes`."""
        raise LookupError(f"{self.objectName()} opens no files such as {path}")

    def go_to(self, view: str) -> None:
        """Show this view of a page that has several."""
        raise LookupError(f"{self.objectName()} has no view {view}")

    def on_escape(self) -> bool:
        """Esc was pressed: go back one step; whether there was one. It never sends anything but LOCK."""
        return False

    def notices(self) -> list[JobNotice]:
        """All that the page says of jobs."""
        return self.findChildren(JobNotice)

    def end_notices(self, *, is_page_left: bool = False) -> None:
        """What was said of another module, or before the page was left, is over; see `JobNotice.end`."""
        for notice in self.notices():
            notice.end(is_page_left=is_page_left)

    def fit(self) -> None:
        """Lay out for the size of the page and of text: called when either changes."""

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.fit()

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        if self.isHidden():  # else the window was, or what the page lies in
            self.end_notices(is_page_left=True)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() != Qt.Key.Key_Escape or not self.on_escape():
            super().keyPressEvent(event)


class StreamPage(Page):
    """A page that draws a stream: it is handed every batch, seen or not."""

    def on_batch(self, batch: Batch) -> None:
        raise NotImplementedError
