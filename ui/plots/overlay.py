"""Words, marks and cursor above the curves, painted by one item of the scene; no word covers another."""

from collections.abc import Sequence
from typing import Final, NamedTuple

from PySide6.QtCore import QLineF, QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPen
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from ui.style import icons
from ui.style.icons import Icon
from ui.style.theme import Size, current, font

ICON_PX: Final = 14
_ICON_GAP_PX: Final = 3
_PAD_PX: Final = 6
"""Beside a word on a ground."""
_DOT_PX: Final = 4
_LEFT: Final = int(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter | Qt.TextFlag.TextDontClip)


class Tag(NamedTuple):
    """A word with its colours as #rrggbb; over curves it has a `ground`."""

    text: str
    ink: str
    is_bold: bool = False
    icon: Icon | None = None
    ground: str = ""


class Overlay(QGraphicsItem):
    """`begin`, then `put` the most important words first. All places are those of the scene."""

    def __init__(self) -> None:
        super().__init__()
        self.setZValue(10)
        self.whole = QRectF()
        """That of the scene."""
        self.shown: list[tuple[Tag, QRectF]] = []
        self.lines: list[tuple[QLineF, QPen]] = []
        self.dots: list[tuple[QPointF, str]] = []
        self.cover = QRectF()
        """Hides what is below it."""
        self.frame: QRectF | None = None
        """The focus."""
        self.restyle(QRectF())

    def boundingRect(self) -> QRectF:
        return self.whole

    def restyle(self, whole: QRectF) -> None:
        """After a change of size, theme or font."""
        self.prepareGeometryChange()
        self.whole = whole
        self._fonts = font(Size.SMALL), font(Size.SMALL, is_bold=True)
        self._metrics = [QFontMetricsF(one) for one in self._fonts]

    def begin(self) -> None:
        self.shown, self.lines, self.dots, self.cover = [], [], [], QRectF()
        self.update()

    def size(self, tag: Tag) -> QSizeF:
        metrics = self._metrics[tag.is_bold]
        width, height = metrics.horizontalAdvance(tag.text), metrics.height()
        if tag.ground:
            width, height = width + 2 * _PAD_PX, height + 4
        if tag.icon is not None:
            width, height = width + ICON_PX + (_ICON_GAP_PX if tag.text else 0), max(height, ICON_PX)
        return QSizeF(width, height)

    def put(self, tag: Tag, *places: QPointF, gap_px: float = 0.0, is_above: bool = False) -> QRectF | None:
        """Shows `tag` at the first of `places`, its upper left corners, where it is `gap_px` from all others, or where
        it `is_above` them. Returns the place, None where there is no room."""
        size = self.size(tag)
        for corner in places:
            room = QRectF(corner, size)
            around = room.adjusted(-gap_px, 0, gap_px, 0)
            if is_above or not any(around.intersects(other) for _, other in self.shown):
                self.shown.append((tag, room))
                return room
        return None

    def paint(self, painter: QPainter, _option: QStyleOptionGraphicsItem, _widget: QWidget | None = None) -> None:
        theme = current()
        for line, ink in self.lines:
            painter.setPen(ink)
            painter.drawLine(line)
        painter.fillRect(self.cover, QColor(theme.surface))
        if self.frame is not None:
            painter.setPen(QPen(QColor(theme.information.ink), 2))
            painter.drawRect(self.frame)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(QColor(theme.surface), 1.5))
        for place, colour in self.dots:
            painter.setBrush(QColor(colour))
            painter.drawEllipse(place, _DOT_PX, _DOT_PX)
        for tag, whole in self.shown:
            room = QRectF(whole.topLeft().toPoint(), whole.size())
            if tag.ground:
                painter.setPen(Qt.PenStyle.NoPen)
                painter.setBrush(QColor(tag.ground))
                painter.drawRoundedRect(room, 4, 4)
                room.setLeft(room.left() + _PAD_PX)
            if tag.icon is not None:
                top = room.top() + (room.height() - ICON_PX) / 2
                icons.draw(painter, tag.icon, QRectF(room.left(), top, ICON_PX, ICON_PX), tag.ink)
                room.setLeft(room.left() + ICON_PX + _ICON_GAP_PX)
            painter.setFont(self._fonts[tag.is_bold])
            painter.setPen(QColor(tag.ink))
            painter.drawText(room, _LEFT, tag.text)


def apart(places: Sequence[float], distance: float, top: float, bottom: float) -> list[float]:
    """`places` pushed apart to at least `distance`, between `top` and `bottom` if they fit."""
    order, moved = sorted(range(len(places)), key=lambda n: places[n]), list(places)
    least, most = top, bottom
    for n in order:
        moved[n] = max(moved[n], least)
        least = moved[n] + distance
    for n in reversed(order):
        moved[n] = min(moved[n], most)
        most = moved[n] - distance
    return moved


def beside(x: float, y: float, size: QSizeF, within: QRectF) -> QPointF:
    """The corner of a tag beside a point: at its right, or at its left where there is no room."""
    left = x + 8 if x + 8 + size.width() <= within.right() else max(0.0, x - 8 - size.width())
    top = min(max(y - size.height() / 2, within.top()), max(within.top(), within.bottom() - size.height()))
    return QPointF(left, top)
