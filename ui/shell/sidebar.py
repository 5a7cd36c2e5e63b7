"""Sidebar with the pages: icons with their names below them, or beside them where that is wanted."""

from typing import Final

from PySide6.QtCore import QEvent, QModelIndex, QPersistentModelIndex, QRect, QSize, Qt, Signal
from PySide6.QtGui import QColor, QFontMetrics, QKeySequence, QPainter, QPen, QResizeEvent
from PySide6.QtWidgets import (
    QListView,
    QListWidget,
    QListWidgetItem,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from app.text.i18n import tr
from ui.core.texts import Texts
from ui.services.context import PageEntry
from ui.style.icons import Icon, draw, icon
from ui.style.theme import Size, Space, current, font, scale_in_use, scaled

WIDE_PX: Final = 160
NARROW_PX: Final = 84
ICONS_PX: Final = 44
WIDE_ROW_PX: Final = 40
NARROW_ROW_PX: Final = 46
_LEAST_NAMED_PX: Final = 39
_LEAST_ROW_PX: Final = 34
"""Of a row without its name, where the window is too low for all rows with theirs."""
_ICON_PX: Final = 20
_ICON: Final = Qt.ItemDataRole.UserRole + 1
_Index = QModelIndex | QPersistentModelIndex


class Sidebar(QListWidget):
    """One row a page; Ctrl+1 … Ctrl+9 and Ctrl+0 reach them from anywhere."""

    page_wanted = Signal(str)

    def __init__(self, entries: tuple[PageEntry, ...], texts: Texts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("navigation")
        self.setProperty("role", "navigation")
        self.setViewMode(QListView.ViewMode.ListMode)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setMouseTracking(True)
        self.setItemDelegate(_RowPainter(self))
        texts.bind(self.setAccessibleName, "Pages")
        self._entries = entries
        self.is_wide = self._has_little_room = False
        for entry in entries:
            item = QListWidgetItem(icon(entry.icon), "")
            item.setData(Qt.ItemDataRole.UserRole, entry.key)
            item.setData(_ICON, entry.icon)
            self.addItem(item)
        self._name_rows()
        self._fit()
        self.currentItemChanged.connect(self._tell)

    def enter(self, _key: str) -> None:
        """The keyboard goes on in the page that was just chosen by its key."""
        self.setFocus()
        self.focusNextChild()

    def choose(self, key: str) -> bool:
        """Go to a page; whether there is one of that key."""
        for row in range(self.count()):
            if self.item(row).data(Qt.ItemDataRole.UserRole) == key:
                self.setCurrentRow(row)
                return True
        return False

    def show_wide(self, is_wide: bool) -> None:
        """Names beside the icons, or below them."""
        self.is_wide = is_wide
        self._fit()

    def give_room(self, has_little: bool) -> None:
        """Only the icons, where a panel beside the page leaves it little room."""
        self._has_little_room = has_little
        self._fit()

    @property
    def chosen(self) -> str:
        return str(self.currentIndex().data(Qt.ItemDataRole.UserRole) or "")

    @property
    def shows_names(self) -> bool:
        """Else there is no room for them; they are in the tooltips."""
        return not self._has_little_room and (self.is_wide or self._row_px() >= _LEAST_NAMED_PX)

    @property
    def scale(self) -> float:
        """Of what is in a row: as the rest of the window, or less where all rows would not fit."""
        wanted = WIDE_ROW_PX if self.is_wide else NARROW_ROW_PX
        return min(scale_in_use(), max(1.0, self._row_px() / wanted))

    def _row_px(self) -> int:
        """How high each row may be for all to be in sight."""
        return max(1, self.height() - 2 * scaled(Space.XS) - 1) // max(1, self.count())

    def _fit(self) -> None:
        wide = self.is_wide and not self._has_little_room
        width = WIDE_PX if wide else ICONS_PX if self._has_little_room else NARROW_PX
        self.setFixedWidth(round(width * self.scale))
        row = round((WIDE_ROW_PX if self.is_wide else NARROW_ROW_PX) * self.scale)
        row = min(row, max(_LEAST_ROW_PX, self._row_px()))
        for number in range(self.count()):
            if self.item(number).sizeHint().height() != row:
                self.item(number).setSizeHint(QSize(0, row))
        self.viewport().update()

    def _tell(self, current: QListWidgetItem | None) -> None:
        if current is not None:
            self.page_wanted.emit(current.data(Qt.ItemDataRole.UserRole))

    def _name_rows(self) -> None:
        for row, entry in enumerate(self._entries):
            key = QKeySequence(f"Ctrl+{(row + 1) % 10}").toString(QKeySequence.SequenceFormat.NativeText)
            title = tr(entry.title)
            self.item(row).setText(title)
            # There are nine digits.
            self.item(row).setToolTip(tr("{page} ({key})", page=title, key=key) if row < 9 else title)

    # Qt

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.LanguageChange:
            self._name_rows()
        elif event.type() == QEvent.Type.PaletteChange and hasattr(self, "_entries"):
            self._fit()


class _RowPainter(QStyledItemDelegate):
    """Icon above name, or beside it; the chosen row on its own ground, with a ring while the list has the focus."""

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
            ground = theme.sunken if theme.border_px == 1 else theme.selection  # a light grey is lost in the sun
            painter.setPen(QPen(QColor(theme.information.ink), 2) if has_ring else Qt.PenStyle.NoPen)
            painter.setBrush(QColor(ground if is_chosen else theme.sunken))
            painter.drawRoundedRect(rect.adjusted(1, 1, -1, -1), 6, 6)
        ink = QColor(theme.text if is_chosen else theme.muted)
        picture: Icon = index.data(_ICON)
        side = round(_ICON_PX * sidebar.scale)
        size = Size.BODY if sidebar.is_wide else Size.SMALL
        name, one = str(index.data()), font(size)
        one.setPixelSize(round(size * sidebar.scale))
        if sidebar.is_wide and sidebar.shows_names:
            square = QRect(rect.left() + scaled(10), rect.center().y() - side // 2 + 1, side, side)
            room = rect.adjusted(scaled(40), 0, -scaled(4), 0)
            flags = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        else:
            high = QFontMetrics(one).height() if sidebar.shows_names else 0
            top = rect.top() + (rect.height() - side - high) // 2
            square = QRect(rect.center().x() - side // 2, top, side, side)
            room = QRect(rect.left(), square.bottom() + 1, rect.width(), high)
            flags = Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignVCenter
        draw(painter, picture, square, ink)
        if sidebar.shows_names:
            painter.setFont(one)
            painter.setPen(ink)
            fitting = QFontMetrics(one).elidedText(name, Qt.TextElideMode.ElideRight, room.width())
            painter.drawText(room, flags, fitting)
        painter.restore()
