"""List of ports with adapter name, manufacturer and serial number."""

from typing import NamedTuple

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QRect, QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QColor, QFont, QFontMetrics, QPainter
from PySide6.QtWidgets import QListWidget, QListWidgetItem, QStyle, QStyledItemDelegate, QStyleOptionViewItem

from app.engine.ports import PortInfo
from app.text.i18n import tr
from ui.style.icons import Icon, draw
from ui.style.theme import Meaning, Size, Space, current, font, scaled

ROW_PX = 48
MAX_ROWS = 6
"""With more rows the list scrolls."""
_CHOICE = Qt.ItemDataRole.UserRole
_Index = QModelIndex | QPersistentModelIndex


class PortChoice(NamedTuple):
    """One row. `badge` is one word, or ""."""

    device: str
    identity: str
    title: str
    product: str
    detail: str
    icon: Icon
    badge: str = ""
    is_new: bool = False

    @property
    def key(self) -> str:
        return self.identity or self.device


def choice_of(port: PortInfo, *, is_new: bool, is_connected: bool, is_last: bool) -> PortChoice:
    name = port.device.removeprefix("/dev/")
    serial = tr("serial number {number}", number=port.serial_number) if port.serial_number else ""
    # Drivers often repeat the manufacturer in the product name.
    maker = "" if port.maker and port.maker.casefold() in port.description.casefold() else port.maker
    product = "" if port.description == name else port.description
    detail = " · ".join(part for part in (maker, serial) if part)
    if not detail:
        detail = tr("no serial number") if product else tr("built in")
    badge = tr("connected") if is_connected else tr("new") if is_new else tr("used last") if is_last else ""
    return PortChoice(port.device, port.identity, name, product, detail, Icon.PLUG, badge, is_new and not is_connected)


class PortList(QListWidget):
    """Keeps its selection while the list changes."""

    activated_choice = Signal(object)
    """A `PortChoice`: Enter or a double click on it."""
    chosen_changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("port_list")
        self.setItemDelegate(_Delegate(self))
        self.setUniformItemSizes(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setMouseTracking(True)
        self.itemActivated.connect(self._activate)
        self.itemSelectionChanged.connect(self.chosen_changed)

    def show_choices(self, choices: list[PortChoice]) -> None:
        """Replaces the rows; the selected port stays selected while it is listed."""
        if choices == [self.choice_at(row) for row in range(self.count())]:
            return
        chosen = self.chosen
        with QSignalBlocker(self):
            self.clear()
            for choice in choices:
                item = QListWidgetItem(choice.title)
                item.setData(_CHOICE, choice)
                item.setData(Qt.ItemDataRole.AccessibleTextRole, _spoken(choice))
                item.setToolTip(_spoken(choice))
                self.addItem(item)
        if chosen is not None:
            self.choose(chosen.key)
        self.updateGeometry()
        self.chosen_changed.emit()

    def choice_at(self, row: int) -> PortChoice:
        choice: PortChoice = self.item(row).data(_CHOICE)
        return choice

    @property
    def chosen(self) -> PortChoice | None:
        rows = self.selectedIndexes()
        return self.choice_at(rows[0].row()) if rows else None

    def choose(self, key: str) -> bool:
        """Selects the row with this key; returns whether there is one."""
        for row in range(self.count()):
            if self.choice_at(row).key == key:
                self.setCurrentRow(row)
                return True
        return False

    def sizeHint(self) -> QSize:
        rows = min(MAX_ROWS, max(2, self.count()))
        return QSize(360, rows * scaled(ROW_PX) + 2 * Space.XS)

    def minimumSizeHint(self) -> QSize:
        return QSize(240, scaled(ROW_PX) + 2 * Space.XS)

    def _activate(self, item: QListWidgetItem) -> None:
        self.activated_choice.emit(item.data(_CHOICE))


def _spoken(choice: PortChoice) -> str:
    return ", ".join(part for part in (choice.title, choice.product, choice.detail, choice.badge) if part)


class _Delegate(QStyledItemDelegate):
    """Draws a row: icon, two lines, and the badge on the right."""

    def sizeHint(self, _option: QStyleOptionViewItem, _index: _Index) -> QSize:
        return QSize(240, scaled(ROW_PX))

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: _Index) -> None:
        choice: PortChoice = index.data(_CHOICE)
        theme = current()
        rect: QRect = option.rect
        state: QStyle.StateFlag = option.state
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        is_selected = bool(state & QStyle.StateFlag.State_Selected)
        if is_selected or state & QStyle.StateFlag.State_MouseOver:
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(QColor(theme.selection if is_selected else theme.raised))
            painter.drawRoundedRect(rect.adjusted(2, 1, -2, -1), 6, 6)
        side = scaled(20)
        square = QRect(rect.left() + Space.M, rect.top() + (rect.height() - side) // 2, side, side)
        draw(painter, choice.icon, square, QColor(theme.text))
        right = self._paint_badge(painter, rect, choice)
        left = square.right() + Space.M
        half = rect.height() // 2
        upper = QRect(left, rect.top() + 4, right - left, half - 4)
        lower = QRect(left, rect.top() + half, right - left, half - 4)
        bold, plain, small = font(Size.BODY, is_bold=True), font(Size.BODY), font(Size.SMALL)
        quiet = QColor(theme.text if is_selected else theme.muted)
        bottom, top = Qt.AlignmentFlag.AlignBottom, Qt.AlignmentFlag.AlignTop
        used = _write(painter, upper, choice.title, bold, QColor(theme.text), bottom)
        _write(painter, upper.adjusted(used + Space.S, 0, 0, 0), choice.product, plain, quiet, bottom)
        _write(painter, lower, choice.detail, small, quiet, top)
        painter.restore()

    def _paint_badge(self, painter: QPainter, rect: QRect, choice: PortChoice) -> int:
        """Draws the badge, if any; returns its left edge."""
        right = rect.right() - Space.M
        if not choice.badge:
            return right
        theme = current()
        badge_font = font(Size.SMALL, is_bold=choice.is_new)
        width = QFontMetrics(badge_font).horizontalAdvance(choice.badge) + 2 * Space.S
        box = QRect(right - width, rect.center().y() - 10, width, 20)
        tint = theme.tint(Meaning.INFORMATION if choice.is_new else Meaning.UNKNOWN)
        painter.setPen(QColor(tint.ink))
        painter.setBrush(QColor(tint.wash if choice.is_new else theme.surface))
        painter.drawRoundedRect(box, 10, 10)
        painter.setFont(badge_font)
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, choice.badge)
        return box.left() - Space.S


def _write(painter: QPainter, room: QRect, text: str, face: QFont, colour: QColor, vertical: Qt.AlignmentFlag) -> int:
    """Draws one elided line; returns its width."""
    metrics = QFontMetrics(face)
    fitting = metrics.elidedText(text, Qt.TextElideMode.ElideRight, max(0, room.width()))
    painter.setFont(face)
    painter.setPen(colour)
    painter.drawText(room, Qt.AlignmentFlag.AlignLeft | vertical, fitting)
    return metrics.horizontalAdvance(fitting)
