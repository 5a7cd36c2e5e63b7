"""Sidebar with the pages: icons with their names below or beside them."""

from typing import Final

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QRect, QSize, Qt, Signal
from PySide6.QtGui import QColor, QFontMetrics, QKeySequence, QPainter, QPen, QResizeEvent
from PySide6.QtWidgets import (
    QListView,
    QListWidget,
    QListWidgetItem,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
)

from app.text.i18n import tr
from ui.core.texts import Texts
from ui.services.context import PageEntry
from ui.style.icons import Icon, draw, icon
from ui.style.theme import Size, Space, current, font, scale_in_use, scaled
from ui.widgets.controls import named
from ui.widgets.visibility_timer import VisibilityTimer

WIDE_PX: Final = 160
NARROW_PX: Final = 84
WIDE_ROW_PX: Final = 40
NARROW_ROW_PX: Final = 46
_MIN_ROW_PX: Final = 32
"""Height of an icon with its name; in a window too low for all rows they scroll."""
_ICON_PX: Final = 20
_ICON: Final = Qt.ItemDataRole.UserRole + 1
_Index = QModelIndex | QPersistentModelIndex


class Sidebar(QListWidget):
    """One row for each page."""

    page_wanted = Signal(str)

    def __init__(self, entries: tuple[PageEntry, ...], texts: Texts) -> None:
        super().__init__()
        named(self, "navigation", "navigation")
        self.setViewMode(QListView.ViewMode.ListMode)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setMouseTracking(True)
        self.setItemDelegate(_RowPainter(self))
        texts.bind(self.setAccessibleName, "Pages")
        self._entries = entries
        self._is_wide_chosen = self._has_little_room = False
        for entry in entries:
            item = QListWidgetItem(icon(entry.icon), "")
            item.setData(Qt.ItemDataRole.UserRole, entry.key)
            item.setData(_ICON, entry.icon)
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
        """Shows names beside the icons where there is room, else below them."""
        self._is_wide_chosen = is_wide
        self._fit()

    def give_room(self, has_little: bool) -> None:
        """Shows names below the icons where a dock beside the page leaves little room."""
        self._has_little_room = has_little
        self._fit()

    @property
    def is_wide(self) -> bool:
        return self._is_wide_chosen and not self._has_little_room

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
        self.viewport().update()

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

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()


class _RowPainter(QStyledItemDelegate):
    """Draws icon and name, highlights the current row, and rings it while the list has the focus."""

    def __init__(self, sidebar: Sidebar) -> None:
        super().__init__(sidebar)
        self._sidebar = sidebar

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: _Index) -> None:
        theme, sidebar = current(), self._sidebar
        state: QStyle.StateFlag = option.state
        is_chosen = bool(state & QStyle.StateFlag.State_Selected)
        is_under_pointer = bool(state & QStyle.StateFlag.State_MouseOver)
        rect: QRect = option.rect
        rect = rect.adjusted(4, 1, -4, -1)
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if is_chosen or is_under_pointer:
            has_ring = is_chosen and sidebar.hasFocus()
            ground = theme.sunken if theme.border_px == 1 else theme.selection  # a light grey is invisible in sunlight
            painter.setPen(QPen(QColor(theme.information.ink), 2) if has_ring else Qt.PenStyle.NoPen)
            painter.setBrush(QColor(ground if is_chosen else theme.sunken))
            painter.drawRoundedRect(rect.adjusted(1, 1, -1, -1), 6, 6)
        ink = QColor(theme.text if is_chosen else theme.muted)
        picture: Icon = index.data(_ICON)
        side = round(_ICON_PX * sidebar.scale)
        size = Size.BODY if sidebar.is_wide else Size.SMALL
        name, name_font = str(index.data()), font(size)
        name_font.setPixelSize(round(size * sidebar.scale))
        metrics = QFontMetrics(name_font)
        if sidebar.is_wide:
            square = QRect(rect.left() + scaled(10), rect.center().y() - side // 2 + 1, side, side)
            room = rect.adjusted(scaled(40), 0, -scaled(4), 0)
            flags = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        else:
            high = metrics.height()
            side = min(side, rect.height() - high)
            top = rect.top() + (rect.height() - side - high) // 2
            square = QRect(rect.center().x() - side // 2, top, side, side)
            room = QRect(rect.left(), square.bottom() + 1, rect.width(), high)
            flags = Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignVCenter
        draw(painter, picture, square, ink)
        painter.setFont(name_font)
        painter.setPen(ink)
        painter.drawText(room, flags, metrics.elidedText(name, Qt.TextElideMode.ElideRight, room.width()))
        painter.restore()
