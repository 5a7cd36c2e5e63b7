"""The pages: making them one by one while the window stays responsive, the area that shows one, the
sidebar, the room on screen."""

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext
from typing import Final

from PySide6.QtCore import QObject, QPoint, QRect, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QKeySequence, QResizeEvent
from PySide6.QtWidgets import (
    QFrame,
    QListWidget,
    QListWidgetItem,
    QScrollArea,
    QSizePolicy,
    QStackedWidget,
    QStyleOptionViewItem,
    QWidget,
)

from app.text.i18n import tr
from app.text.sentences import in_brackets
from ui.core.bridge import Bridge
from ui.services.context import PageEntry, Services
from ui.services.page import Page
from ui.session.shown_module import ShownModule
from ui.style.icons import icon
from ui.style.theme import IconSize, Size, Space, font, scale_in_use, scaled
from ui.widgets.controls import named
from ui.widgets.visibility_timer import VisibilityTimer

FRAME: Final = QSize(4, 36)
"""Size of a window's title bar and edges, before the system reports it."""


def fitting(target: QRect, free: QRect) -> QRect:
    """`target`, moved and shrunk until it lies within `free`."""
    size = target.size().boundedTo(free.size())
    left = min(max(target.left(), free.left()), free.left() + free.width() - size.width())
    top = min(max(target.top(), free.top()), free.top() + free.height() - size.height())
    return QRect(QPoint(left, top), size)


def free_area(window: QWidget) -> QRect:
    """The part of the screen where the inside of the window may be, in logical pixels."""
    frame = window.frameGeometry().size() - window.geometry().size() if window.isVisible() else QSize()
    frame = frame.expandedTo(FRAME)
    return (
        window.screen()
        .availableGeometry()
        .adjusted(frame.width() // 2, frame.height() - frame.width() // 2, -frame.width() // 2, -frame.width() // 2)
    )


def fit_screen(window: QWidget, smallest: QSize) -> None:
    """Keeps the window on its screen, whose size also limits the minimum size `smallest`."""
    free = free_area(window)
    window.setMinimumSize(smallest.boundedTo(free.size()))
    if not window.isMaximized() and not window.isFullScreen():
        window.setGeometry(fitting(window.geometry(), free))


BREATH_MS: Final = 1
"""Between two turns; with 0 Qt would process no other events."""
_BATCH_PAGES: Final = ("diagnosis", "live")
"""Pages that need every batch from the first byte on; connecting waits only for these."""
_IN_SIGHT: Final = QSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Preferred)
_OUT_OF_SIGHT: Final = QSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)


class _Pages(QStackedWidget):
    """At least as high as the page in sight needs: Qt would take the highest of all pages, and their usual heights."""

    def heightForWidth(self, width: int) -> int:
        page = self.currentWidget()
        layout = None if page is None else page.layout()
        return -1 if layout is None or not layout.hasHeightForWidth() else layout.minimumHeightForWidth(width)


class PageArea(QScrollArea):
    """Scrolls the page in sight where it does not fit. `stack` holds all pages."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("page_area")
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.stack = named(_Pages(), "pages")
        self.setWidget(self.stack)
        self.stack.currentChanged.connect(self._on_page)
        self.viewport().setAutoFillBackground(False)
        self.stack.setAutoFillBackground(False)

    def add(self, page: QWidget) -> None:
        # A stack asks for the room of all its pages; one whose size is ignored counts for nothing.
        page.setSizePolicy(_OUT_OF_SIGHT)
        self.stack.addWidget(page)

    def _on_page(self) -> None:
        for page in filter(None, map(self.stack.widget, range(self.stack.count()))):
            page.setSizePolicy(_IN_SIGHT if page is self.stack.currentWidget() else _OUT_OF_SIGHT)
        self.verticalScrollBar().setValue(0)

    @property
    def holders(self) -> tuple[QWidget, ...]:
        """The widgets around the pages, from the outside in."""
        return (self, self.viewport(), self.stack)


class PageMaker(QObject):
    """Makes and places one page in each turn of the event loop."""

    done = Signal()
    """All pages were made and placed, except those that failed."""

    def __init__(
        self,
        services: Services,
        entries: Iterable[PageEntry],
        place: Callable[[str, Page], None],
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.pages: dict[str, Page] = {}
        """The pages made so far, by key."""
        self._entries = {entry.key: entry for entry in entries}
        self._ports, self._services, self._place = services.ports, services, place
        self._unmade = list(self._entries)
        self._awaited = self._entries.keys() & set(_BATCH_PAGES) or set(self._entries)
        """Pages that batches are held back for."""
        self._held = set[Bridge]()
        """Where they are: another port may be shown before the pages are there."""
        self._is_over = False
        self.around: Callable[[], AbstractContextManager[None]] = nullcontext
        """Entered while a page is made."""
        self._ports.shown.connect(self._show_module)

    @property
    def is_done(self) -> bool:
        return not self._unmade

    def begin(self) -> None:
        """Starts with the next turn of the event loop."""
        QTimer.singleShot(BREATH_MS, self, self._make_next)

    def request(self, key: str) -> None:
        if key in self._unmade:
            self._unmade.remove(key)
            self._unmade.insert(0, key)

    def hold_batches(self) -> None:
        """Holds all batches of the port back until the pages that need each of them are there."""
        if self._awaited:
            bridge = self._ports.current.bridge
            bridge.hold()
            self._held.add(bridge)
            for key in _BATCH_PAGES:
                self.request(key)

    def end(self) -> None:
        self._is_over = True

    def _show_module(self, module: ShownModule) -> None:
        for page in self.pages.values():
            page.show_module(module)

    def _release(self) -> None:
        held, self._held = self._held, set()
        for bridge in held:
            bridge.release()

    def _make_next(self) -> None:
        if self._is_over:
            return
        if self.is_done:
            self._release()
            self.done.emit()
            return
        self.begin()  # first, since making a page may raise
        key = self._unmade.pop(0)
        entry = self._entries[key]
        with self.around():
            page = self.pages[key] = entry.make(self._services)
            page.setAccessibleName(tr(entry.title))
            page.show_module(self._ports.module)
        self._place(key, page)
        self._awaited.discard(key)
        if not self._awaited:
            self._release()


WIDE_PX: Final = 160
NARROW_PX: Final = 84
WIDE_ROW_PX: Final = 40
NARROW_ROW_PX: Final = 46
_MIN_ROW_PX: Final = 32
"""Height of an icon with its name; in a window too low for all rows they scroll."""


class Sidebar(QListWidget):
    """One row for each page."""

    page_wanted = Signal(str)

    def __init__(self, entries: tuple[PageEntry, ...]) -> None:
        super().__init__()
        named(self, "navigation", "navigation")
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setMouseTracking(True)
        self.setAccessibleName(tr("Pages"))
        self._entries = entries
        self.is_wide = False
        for entry in entries:
            item = QListWidgetItem(icon(entry.icon), "")
            item.setData(Qt.ItemDataRole.UserRole, entry.key)
            self.addItem(item)
        self._name_rows()
        self._fit()
        self.currentItemChanged.connect(self._on_current_changed)
        self.itemClicked.connect(self._on_current_changed)  # from the list of ports back to the same page
        VisibilityTimer(self, self._fit, restyle=self._fit)

    def choose(self, key: str) -> bool:
        """Chooses the page with this key; returns whether there is one."""
        for row in range(self.count()):
            if self.item(row).data(Qt.ItemDataRole.UserRole) == key:
                self.setCurrentRow(row)
                return True
        return False

    def choose_wide(self, is_wide: bool) -> None:
        self.is_wide = is_wide
        self._fit()

    @property
    def chosen(self) -> str:
        return str(self.currentIndex().data(Qt.ItemDataRole.UserRole) or "")

    @property
    def scale(self) -> float:
        """Scale of a row: that of the window, or less where not all rows would fit."""
        usual_px = WIDE_ROW_PX if self.is_wide else NARROW_ROW_PX
        return min(scale_in_use(), max(1.0, self._row_px() / usual_px))

    def _row_px(self) -> int:
        """The height at which all rows fit."""
        return max(1, self.height() - 2 * scaled(Space.XS) - 1) // max(1, self.count())

    def _fit(self) -> None:
        self.setFixedWidth(round((WIDE_PX if self.is_wide else NARROW_PX) * self.scale))
        row = round((WIDE_ROW_PX if self.is_wide else NARROW_ROW_PX) * self.scale)
        row = min(row, max(_MIN_ROW_PX, self._row_px()))
        for number in range(self.count()):
            if self.item(number).sizeHint().height() != row:
                self.item(number).setSizeHint(QSize(0, row))
        letters, size = font(), Size.BODY if self.is_wide else Size.SMALL
        letters.setPixelSize(round(size * self.scale))
        self.setFont(letters)
        room = row if self.is_wide else row - self.fontMetrics().height() - Space.XS
        self.setIconSize(QSize(1, 1) * min(round(IconSize.NOTICE * self.scale), room))

    def _on_current_changed(self, current: QListWidgetItem | None) -> None:
        if current is not None:
            self.page_wanted.emit(current.data(Qt.ItemDataRole.UserRole))

    def _name_rows(self) -> None:
        for row, entry in enumerate(self._entries):
            key = QKeySequence(f"Ctrl+{(row + 1) % 10}").toString(QKeySequence.SequenceFormat.NativeText)
            title = tr(entry.title)
            self.item(row).setText(title)
            self.item(row).setToolTip(title + in_brackets(key))

    # Qt

    def initViewItemOption(self, option: QStyleOptionViewItem) -> None:
        super().initViewItemOption(option)
        if not self.is_wide:
            option.decorationPosition = QStyleOptionViewItem.Position.Top
            option.displayAlignment = Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignTop

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()
