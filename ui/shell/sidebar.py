"""Sidebar with the pages: icons with their names below or beside them."""

from typing import Final

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QKeySequence, QResizeEvent
from PySide6.QtWidgets import QListWidget, QListWidgetItem, QStyleOptionViewItem

from app.text.i18n import tr
from ui.core.texts import Texts
from ui.services.context import PageEntry
from ui.style.icons import icon
from ui.style.theme import Size, Space, font, scale_in_use, scaled
from ui.widgets.controls import named
from ui.widgets.visibility_timer import VisibilityTimer

WIDE_PX: Final = 160
NARROW_PX: Final = 84
WIDE_ROW_PX: Final = 40
NARROW_ROW_PX: Final = 46
_MIN_ROW_PX: Final = 32
"""Height of an icon with its name; in a window too low for all rows they scroll."""
_ICON_PX: Final = 20
_BETWEEN_PX: Final = 4
"""Around an icon with its name below it."""


class Sidebar(QListWidget):
    """One row for each page."""

    page_wanted = Signal(str)

    def __init__(self, entries: tuple[PageEntry, ...], texts: Texts) -> None:
        super().__init__()
        named(self, "navigation", "navigation")
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setMouseTracking(True)
        texts.bind(self.setAccessibleName, "Pages")
        self._entries = entries
        self.is_wide = False
        for entry in entries:
            item = QListWidgetItem(icon(entry.icon), "")
            item.setData(Qt.ItemDataRole.UserRole, entry.key)
            self.addItem(item)
        self._name_rows()
        self._fit()
        self.currentItemChanged.connect(self._on_current_changed)
        VisibilityTimer(self, self._fit, retranslate=self._name_rows, restyle=self._fit)

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
        room = row if self.is_wide else row - self.fontMetrics().height() - _BETWEEN_PX
        self.setIconSize(QSize(1, 1) * min(round(_ICON_PX * self.scale), room))

    def _on_current_changed(self, current: QListWidgetItem | None) -> None:
        if current is not None:
            self.page_wanted.emit(current.data(Qt.ItemDataRole.UserRole))

    def _name_rows(self) -> None:
        for row, entry in enumerate(self._entries):
            key = QKeySequence(f"Ctrl+{(row + 1) % 10}").toString(QKeySequence.SequenceFormat.NativeText)
            title = tr(entry.title)
            self.item(row).setText(title)
            self.item(row).setToolTip(tr("{tip} ({key})", tip=title, key=key))

    # Qt

    def initViewItemOption(self, option: QStyleOptionViewItem) -> None:
        super().initViewItemOption(option)
        if not self.is_wide:
            option.decorationPosition = QStyleOptionViewItem.Position.Top
            option.displayAlignment = Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignTop

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()
