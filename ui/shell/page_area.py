"""The pages: making them one by one while the window stays responsive, the area that shows one, the sidebar."""

from collections.abc import Iterable
from typing import Final

from PySide6.QtCore import QMargins, QObject, QRect, QSize, Qt, QTimer, Signal
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
from app.text.messages import in_brackets
from ui.services.context import PageEntry, Services
from ui.services.page import Page
from ui.style.icons import icon
from ui.style.theme import IconSize, Size, Space, font, scale_in_use
from ui.widgets.controls import named

# A window's title bar and edges: the system reports them only once it is shown.
FRAME: Final = QMargins(2, 34, 2, 2)
# Between two pages that are made; with 0 Qt would process no other events.
BREATH_MS: Final = 1
# Larger names would take the pages' room; above this scale they stand without their icons, so that all are in sight.
_LARGEST_SCALE: Final = 1.25
_IN_SIGHT: Final = QSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Preferred)
_OUT_OF_SIGHT: Final = QSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)


def fit_screen(window: QWidget, smallest: QSize) -> None:
    """Keeps the window on its screen, whose size also limits the minimum size `smallest`."""
    free = window.screen().availableGeometry().marginsRemoved(FRAME)
    window.setMinimumSize(smallest.boundedTo(free.size()))
    if window.isMaximized() or window.isFullScreen():
        return
    place = QRect(window.geometry().topLeft(), window.size().boundedTo(free.size()))
    place.moveRight(min(place.right(), free.right()))
    place.moveBottom(min(place.bottom(), free.bottom()))
    place.moveLeft(max(place.left(), free.left()))
    place.moveTop(max(place.top(), free.top()))
    window.setGeometry(place)


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


class PageMaker(QObject):
    """Makes one page in each turn of the event loop."""

    made = Signal(str)
    """The page with this key is in `pages`."""
    done = Signal()
    """All pages were made, except those that failed."""

    def __init__(self, services: Services, entries: Iterable[PageEntry], parent: QObject) -> None:
        super().__init__(parent)
        self._services = services
        self._unmade = list(entries)
        self.pages: dict[str, Page] = {}
        self.is_done = False
        self._turns = QTimer(self, interval=BREATH_MS)
        self._turns.timeout.connect(self._make_next)

    def begin(self) -> None:
        self._turns.start()

    def request(self, key: str) -> None:
        """Make the page with this key next."""
        self._unmade.sort(key=lambda entry: entry.key != key)

    def end(self) -> None:
        self._turns.stop()

    def _make_next(self) -> None:
        if not self._unmade:
            self._turns.stop()
            self.is_done = True
            self.done.emit()
            return
        entry = self._unmade.pop(0)
        page = entry.make(self._services)
        page.setAccessibleName(tr(entry.title))
        page.show_module(self._services.ports.module)
        self._services.ports.shown.connect(page.show_module)
        self.pages[entry.key] = page
        self.made.emit(entry.key)


class Sidebar(QListWidget):
    """One row for each page: its icon above its name; in large text its name alone."""

    page_wanted = Signal(str)

    def __init__(self, entries: Iterable[PageEntry]) -> None:
        super().__init__()
        named(self, "navigation", "navigation")
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setMouseTracking(True)
        self.setAccessibleName(tr("Pages"))
        scale = min(scale_in_use(), _LARGEST_SCALE)
        has_icons = scale_in_use() <= _LARGEST_SCALE
        self.setSpacing(Space.XS // 2)
        self.setIconSize(QSize(1, 1) * round(scale * IconSize.NOTICE))
        letters = font()
        letters.setPixelSize(round(scale * Size.SMALL))
        self.setFont(letters)
        for number, entry in enumerate(entries, start=1):
            title = tr(entry.title)
            item = QListWidgetItem(icon(entry.icon), title) if has_icons else QListWidgetItem(title)
            item.setData(Qt.ItemDataRole.UserRole, entry.key)
            item.setToolTip(title + in_brackets(f"Ctrl+{number % 10}"))
            self.addItem(item)
        self.setFixedWidth(self.sizeHintForColumn(0) + Space.L)
        self.currentItemChanged.connect(self._on_current_changed)
        self.itemClicked.connect(self._on_current_changed)  # from the list of ports back to the same page

    def choose(self, key: str) -> None:
        """Chooses the page with this key."""
        for row in range(self.count()):
            if self.item(row).data(Qt.ItemDataRole.UserRole) == key:
                self.setCurrentRow(row)

    @property
    def chosen(self) -> str:
        return str(self.currentIndex().data(Qt.ItemDataRole.UserRole) or "")

    def _on_current_changed(self, current: QListWidgetItem | None) -> None:
        if current is not None:
            self.page_wanted.emit(current.data(Qt.ItemDataRole.UserRole))

    def initViewItemOption(self, option: QStyleOptionViewItem) -> None:
        super().initViewItemOption(option)
        option.decorationPosition = QStyleOptionViewItem.Position.Top
        option.displayAlignment = Qt.AlignmentFlag.AlignCenter
