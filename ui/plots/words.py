"""Words and icons in front of the curves, as items of the scene; none covers another."""

from collections.abc import Sequence
from typing import Final

from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPen
from PySide6.QtWidgets import (
    QGraphicsEllipseItem,
    QGraphicsItem,
    QGraphicsPathItem,
    QGraphicsRectItem,
    QGraphicsScene,
    QGraphicsSimpleTextItem,
    QStyleOptionGraphicsItem,
    QWidget,
)

from ui.style.theme import Size, current, font

GAP_PX: Final = 4
"""Beside a word, between it and others."""
PAD_PX: Final = 6
"""Beside a word on a ground."""
_ROUND_PX: Final = 4
_DOT_PX: Final = 4


class Dot(QGraphicsEllipseItem):
    """At a sample."""

    def __init__(self, colour: str) -> None:
        super().__init__(-_DOT_PX, -_DOT_PX, 2 * _DOT_PX, 2 * _DOT_PX)
        self.setPen(QPen(QColor(current().surface), 1.5))
        self.setBrush(QColor(colour))

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        super().paint(painter, option, widget)


class Words:
    """`clear`, then `put` what `made` and other items, the most important first. Places are those of the scene."""

    def __init__(self, scene: QGraphicsScene) -> None:
        self._scene = scene
        self._root = QGraphicsRectItem()
        self._rooms: list[QRectF] = []
        self.clear()

    @property
    def shown(self) -> list[QGraphicsItem]:
        """In the order in which they were put."""
        return self._root.childItems()

    def clear(self) -> None:
        if self._root.scene() is not None:
            self._scene.removeItem(self._root)
        self._root, self._rooms = QGraphicsRectItem(), []
        self._fonts = font(Size.SMALL), font(Size.SMALL, is_bold=True)
        self._root.setZValue(10)
        self._scene.addItem(self._root)

    def made(self, text: str, ink: str, *, is_bold: bool = False, ground: str = "") -> QGraphicsItem:
        """A word in colours as #rrggbb; over curves it has a `ground`."""
        word = QGraphicsSimpleTextItem(text)
        word.setFont(self._fonts[is_bold])
        word.setBrush(QColor(ink))
        word.setCacheMode(QGraphicsItem.CacheMode.DeviceCoordinateCache)
        if not ground:
            return word
        outline = QPainterPath()
        outline.addRoundedRect(word.boundingRect().adjusted(-PAD_PX, -2, PAD_PX, 2), _ROUND_PX, _ROUND_PX)
        plate = QGraphicsPathItem(outline)
        plate.setPen(Qt.PenStyle.NoPen)
        plate.setBrush(QColor(ground))
        word.setParentItem(plate)
        return plate

    def put(self, item: QGraphicsItem, *places: QPointF, is_above: bool = False) -> QRectF | None:
        """Shows `item` at the first of `places`, its upper left corners, where it is apart from all others, or where it
        `is_above` them. Returns the place, None where there is no room."""
        box = item.boundingRect()
        for corner in places:
            room = QRectF(corner.toPoint(), box.size())
            around = room.adjusted(-GAP_PX, 0, GAP_PX, 0)
            if is_above or not any(around.intersects(other) for other in self._rooms):
                self._rooms.append(room)
                item.setPos(room.topLeft() - box.topLeft())
                item.setParentItem(self._root)
                return room
        return None


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
    """The corner of a word beside a point: at its right, or at its left where there is no room."""
    left = x + 8 if x + 8 + size.width() <= within.right() else max(0.0, x - 8 - size.width())
    top = min(max(y - size.height() / 2, within.top()), max(within.top(), within.bottom() - size.height()))
    return QPointF(left, top)
