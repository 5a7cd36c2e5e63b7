"""Words on the plots, of which none covers another."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final, NamedTuple

from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter
from PySide6.QtWidgets import QGraphicsItem, QGraphicsScene, QStyleOptionGraphicsItem, QWidget

from ui.style import icons
from ui.style.icons import Icon
from ui.style.theme import Size, current, font

ICON_PX: Final = 14
_ICON_GAP_PX: Final = 3
_PAD_PX: Final = 6
"""Beside a word on a ground."""
_UNIT_GAP_PX: Final = 6
_CENTRE: Final = int(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextDontClip)
_LEFT: Final = int(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter | Qt.TextFlag.TextDontClip)
_RIGHT: Final = int(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter | Qt.TextFlag.TextDontClip)


class Tag(NamedTuple):
    """A word with its colours as #rrggbb; over curves it has a `ground`. `unit` follows it in a lighter colour."""

    text: str
    ink: str
    is_bold: bool = False
    icon: Icon | None = None
    ground: str = ""
    unit: str = ""


class _TagItem(QGraphicsItem):
    """Paints a tag in the coordinates of the scene."""

    def __init__(self) -> None:
        super().__init__()
        self.tag = Tag("", "")
        self._size = QSizeF()
        self.setZValue(10)
        self.setCacheMode(QGraphicsItem.CacheMode.DeviceCoordinateCache)

    def show_tag(self, tag: Tag, place: QRectF) -> None:
        if (tag, place.size()) != (self.tag, self._size):
            self.prepareGeometryChange()
            self.tag, self._size = tag, place.size()
            self.update()
        self.setPos(place.topLeft().toPoint().toPointF())
        self.show()

    def boundingRect(self) -> QRectF:
        return QRectF(QPointF(), self._size).adjusted(-1, -2, 1, 2)  # Chinese glyphs are taller

    def paint(self, painter: QPainter, _option: QStyleOptionGraphicsItem, _widget: QWidget | None = None) -> None:
        tag, room = self.tag, QRectF(QPointF(), self._size)
        if tag.ground:
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(QColor(tag.ground))
            painter.drawRoundedRect(room, 4, 4)
        if tag.icon is not None:
            top = (room.height() - ICON_PX) / 2
            icons.draw(painter, tag.icon, QRectF(0, top, ICON_PX, ICON_PX), QColor(tag.ink))
            room.setLeft(ICON_PX + _ICON_GAP_PX)
        if tag.unit:
            painter.setFont(font(Size.SMALL))
            painter.setPen(QColor(current().muted))
            painter.drawText(room, _RIGHT, tag.unit)
        painter.setFont(font(Size.SMALL, is_bold=tag.is_bold))
        painter.setPen(QColor(tag.ink))
        painter.drawText(room, _LEFT if tag.unit or not tag.ground else _CENTRE, tag.text)


class Tags:
    """The tags of one picture: `begin`, `put` the most important first, `end`."""

    def __init__(self, scene: QGraphicsScene) -> None:
        self._scene = scene
        self._items: list[_TagItem] = []
        self._count = 0
        self._taken: list[QRectF] = []
        self._sizes: dict[tuple[object, ...], QSizeF] = {}

    @property
    def shown(self) -> list[tuple[Tag, QRectF]]:
        """The tags in sight with their places in the scene."""
        items = (item for item in self._items if item.isVisible())
        return [(item.tag, item.mapRectToScene(QRectF(QPointF(), item._size))) for item in items]

    def apply_theme(self) -> None:
        """Measures again."""
        self._sizes.clear()
        for item in self._items:
            item.tag = Tag("", "")

    def size(self, tag: Tag) -> QSizeF:
        key = tag.text, tag.unit, tag.is_bold, tag.icon is not None, bool(tag.ground)
        if key not in self._sizes:
            metrics = QFontMetricsF(font(Size.SMALL, is_bold=tag.is_bold))
            width, height = metrics.horizontalAdvance(tag.text), metrics.height()
            if tag.unit:
                width += _UNIT_GAP_PX + QFontMetricsF(font(Size.SMALL)).horizontalAdvance(tag.unit)
            if tag.ground:
                width, height = width + 2 * _PAD_PX, height + 4
            if tag.icon is not None:
                width, height = width + ICON_PX + (_ICON_GAP_PX if tag.text else 0), max(height, ICON_PX)
            if len(self._sizes) > 500:  # times of day
                self._sizes.clear()
            self._sizes[key] = QSizeF(width, height)
        return self._sizes[key]

    def begin(self) -> None:
        self._count = 0
        self._taken = []

    def put(self, tag: Tag, *places: QPointF, gap_px: float = 0.0, is_above: bool = False) -> QRectF | None:
        """Shows `tag` at the first of `places`, its upper left corners, where it is `gap_px` from all others, or where
        it `is_above` them. Returns the place, None where there is no room."""
        size = self.size(tag)
        for corner in places:
            room = QRectF(corner, size)
            around = room.adjusted(-gap_px, 0, gap_px, 0)
            if is_above or not any(around.intersects(other) for other in self._taken):
                break
        else:
            return None
        self._taken.append(room)
        if self._count == len(self._items):
            item = _TagItem()
            self._scene.addItem(item)
            self._items.append(item)
        self._items[self._count].show_tag(tag, room)
        self._count += 1
        return room

    def end(self) -> None:
        for item in self._items[self._count :]:
            item.hide()


def apart(places: Sequence[float], distance: float, top: float, bottom: float) -> list[float]:
    """`places` pushed apart to at least `distance`, between `top` and `bottom` if they fit."""
    order = sorted(range(len(places)), key=lambda n: places[n])
    moved = list(places)
    for _ in range(4 * len(order)):  # pushing two apart may push one onto a third
        for upper, lower in pairwise(order):
            lacking = distance - (moved[lower] - moved[upper])
            if lacking > 0:
                moved[upper] -= lacking / 2
                moved[lower] += lacking / 2
    if order:
        down = max(0.0, top - moved[order[0]])
        up = max(0.0, moved[order[-1]] + down - bottom)
        moved = [place + down - up for place in moved]
    return moved


def beside(x: float, y: float, size: QSizeF, within: QRectF) -> QPointF:
    """The corner of a tag beside a point: at its right, or at its left where there is no room."""
    left = x + 8 if x + 8 + size.width() <= within.right() else max(0.0, x - 8 - size.width())
    top = min(max(y - size.height() / 2, within.top()), max(within.top(), within.bottom() - size.height()))
    return QPointF(left, top)
