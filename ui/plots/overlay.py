"""What lies in front of the lanes: words and icons, none of which covers another, lines through all lanes, and dots."""

from collections.abc import Iterable
from functools import lru_cache
from typing import Final, NamedTuple

from PySide6.QtCore import QLineF, QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPen, QStaticText, QTransform
from PySide6.QtWidgets import QGraphicsRectItem, QStyleOptionGraphicsItem, QWidget

from ui.style import icons
from ui.style.icons import Icon
from ui.style.theme import Size, current, font

GAP_PX: Final = 4
"""Beside a word, between it and others."""
PAD_PX: Final = 6
_PAD_Y_PX: Final = 2
"""Around a word on a ground."""
ICON_PX: Final = 14
_ROUND_PX: Final = 4
_DOT_PX: Final = 4
_MAX_TEXTS: Final = 200
"""Kept laid out."""


class Shown(NamedTuple):
    """A word or an icon in its room; over curves a word has a ground."""

    what: str | Icon
    room: QRectF
    ink: QColor | str
    is_bold: bool
    ground: str


class Overlay(QGraphicsRectItem):
    """`clear`, then `put` words and icons, the most important first. Places are those of the scene, its rectangle is
    the whole of that."""

    def __init__(self) -> None:
        super().__init__()
        self.setZValue(10)
        self.shown: list[Shown] = []
        self.lines: list[tuple[float, QColor | str]] = []
        """Their places across, and their colours."""
        self.dots: list[tuple[QPointF, str]] = []
        self._box = QRectF()
        self._has_focus = False
        self.apply_theme()

    def apply_theme(self) -> None:
        self.fonts = font(Size.SMALL), font(Size.SMALL, is_bold=True)
        self.line_px = QFontMetricsF(self.fonts[True]).height()
        self._laid_out = lru_cache(_MAX_TEXTS)(self._lay_out)  # which takes longer than drawing it

    def clear(self, box: QRectF, *, has_focus: bool) -> None:
        """`box`: all lanes, through which lines go; it is framed if it `has_focus`."""
        self.update()
        self._box, self._has_focus = box, has_focus
        for part in (self.shown, self.lines, self.dots):
            part.clear()

    def size(self, what: str | Icon, *, is_bold: bool = False, is_on_ground: bool = False) -> QSizeF:
        if isinstance(what, Icon):
            return QSizeF(ICON_PX, ICON_PX)
        size = self._laid_out(what, is_bold).size()
        return size + QSizeF(2 * PAD_PX, _PAD_Y_PX * 2) if is_on_ground else size

    def _lay_out(self, text: str, is_bold: bool, /) -> QStaticText:
        laid_out = QStaticText(text)
        laid_out.setTextFormat(Qt.TextFormat.PlainText)
        laid_out.prepare(QTransform(), self.fonts[is_bold])
        return laid_out

    def put(
        self, what: str | Icon, ink: QColor | str, places: Iterable[QPointF], *, is_bold: bool = False,
        ground: str = "", is_above: bool = False,
    ) -> QRectF | None:  # fmt: skip
        """Shows a word or an icon at the first of `places`, its upper left corners, where it is apart from all others,
        or where it `is_above` them. Returns its room, None where there is none."""
        size = self.size(what, is_bold=is_bold, is_on_ground=bool(ground))
        for corner in places:
            room = QRectF(corner.toPoint(), size)
            around = room.adjusted(-GAP_PX, 0, GAP_PX, 0)
            if is_above or not any(around.intersects(other.room) for other in self.shown):
                self.shown.append(Shown(what, room, ink, is_bold, ground))
                return room
        return None

    def paint(self, painter: QPainter, _option: QStyleOptionGraphicsItem, _widget: QWidget | None = None) -> None:
        theme = current()
        if self._has_focus:
            painter.setPen(QPen(QColor(theme.information.ink), 2))
            painter.drawRect(self._box)
        for x, ink in self.lines:
            painter.setPen(QColor(ink))
            painter.drawLine(QLineF(x, self._box.top(), x, self._box.bottom()))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(QColor(theme.surface), 1.5))
        for place, ink in self.dots:
            painter.setBrush(QColor(ink))
            painter.drawEllipse(place, _DOT_PX, _DOT_PX)
        for what, room, ink, is_bold, ground in self.shown:
            if isinstance(what, Icon):
                icons.draw(painter, what, room, ink)
                continue
            if ground:
                painter.setPen(Qt.PenStyle.NoPen)
                painter.setBrush(QColor(ground))
                painter.drawRoundedRect(room, _ROUND_PX, _ROUND_PX)
            painter.setFont(self.fonts[is_bold])
            painter.setPen(QColor(ink))
            corner = room.topLeft() + QPointF(PAD_PX, _PAD_Y_PX) if ground else room.topLeft()
            painter.drawStaticText(corner, self._laid_out(what, is_bold))


def beside(x: float, y: float, size: QSizeF, within: QRectF) -> QPointF:
    """The corner of a word beside a point: at its right, or at its left where there is no room."""
    left = x + 8 if x + 8 + size.width() <= within.right() else max(0.0, x - 8 - size.width())
    top = min(max(y - size.height() / 2, within.top()), max(within.top(), within.bottom() - size.height()))
    return QPointF(left, top)
