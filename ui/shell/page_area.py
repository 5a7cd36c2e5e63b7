"""The area that shows one page, and the sidebar that chooses it."""

from collections.abc import Iterable
from typing import Final

from PySide6.QtCore import QSize, Qt, Signal
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
from ui.services.context import PageEntry
from ui.style.icons import icon
from ui.style.theme import IconSize, Size, Space, font, scale_in_use
from ui.widgets.controls import named

# Larger names would take the pages' room; above this scale they stand without their icons, so that all are in sight.
_LARGEST_SCALE: Final = 1.25
_IN_SIGHT: Final = QSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Preferred)
# A stack asks for the room of all its pages; one whose size is ignored counts for nothing.
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
        for ground in (self.viewport(), self.stack):
            ground.setAutoFillBackground(False)

    def add(self, page: QWidget) -> None:
        page.setSizePolicy(_OUT_OF_SIGHT)
        self.stack.addWidget(page)

    def _on_page(self) -> None:
        for page in filter(None, map(self.stack.widget, range(self.stack.count()))):
            page.setSizePolicy(_IN_SIGHT if page is self.stack.currentWidget() else _OUT_OF_SIGHT)
        self.verticalScrollBar().setValue(0)


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
        self.setSpacing(Space.XS // 2)
        self.setIconSize(QSize(1, 1) * round(scale * IconSize.NOTICE))
        letters = font()
        letters.setPixelSize(round(scale * Size.SMALL))
        self.setFont(letters)
        for number, entry in enumerate(entries, start=1):
            title = tr(entry.title)
            item = QListWidgetItem(title)
            if scale_in_use() <= _LARGEST_SCALE:
                item.setIcon(icon(entry.icon))
            item.setData(Qt.ItemDataRole.UserRole, entry.key)
            item.setToolTip(title + in_brackets(f"Ctrl+{number % 10}"))
            self.addItem(item)
        self.setFixedWidth(self.sizeHintForColumn(0) + Space.L)
        self.currentItemChanged.connect(self._on_item)
        self.itemClicked.connect(self._on_item)  # from the list of ports back to the same page

    def choose(self, key: str) -> None:
        for row in range(self.count()):
            if self.item(row).data(Qt.ItemDataRole.UserRole) == key:
                self.setCurrentRow(row)

    @property
    def chosen(self) -> str:
        """The key of the page."""
        return str(self.currentIndex().data(Qt.ItemDataRole.UserRole) or "")

    def _on_item(self, item: QListWidgetItem | None) -> None:
        if item is not None:
            self.page_wanted.emit(item.data(Qt.ItemDataRole.UserRole))

    def initViewItemOption(self, option: QStyleOptionViewItem) -> None:
        super().initViewItemOption(option)
        option.decorationPosition = QStyleOptionViewItem.Position.Top
        option.displayAlignment = Qt.AlignmentFlag.AlignCenter
