"""Pictures of what to do in each step of a guided test, drawn on a canvas of 280 by 170 in the theme's colours."""

from collections.abc import Callable, Mapping
from math import cos, radians, sin
from typing import Final

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPen, QPolygonF

from app.guided.results import GuidedKind
from app.text.i18n import tr
from protocol.translatable import marked
from ui.style.icons import Icon, draw
from ui.style.theme import Meaning, Size, Theme, current, font

WIDTH, HEIGHT = 280.0, 170.0
_BODY_W, _BODY_H, _LID_H = 84.0, 44.0, 12.0


class Pencil:
    """Draws the parts that the pictures share. Thick lines in sunlight."""

    def __init__(self, painter: QPainter) -> None:
        self.painter, self.theme = painter, current()
        self.line_px = 2.0 if self.theme.line_px == 1 else 3.0

    def ink(self, colour: str, *, width: float | None = None, is_dashed: bool = False) -> None:
        one = QPen(QColor(colour), width or self.line_px)
        one.setCapStyle(Qt.PenCapStyle.RoundCap)
        one.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        if is_dashed:
            one.setDashPattern([3, 3])
        self.painter.setPen(one)
        self.painter.setBrush(Qt.BrushStyle.NoBrush)

    def line(self, *points: tuple[float, float]) -> None:
        self.painter.drawPolyline([QPointF(x, y) for x, y in points])

    def arrow(self, begin: tuple[float, float], end: tuple[float, float]) -> None:
        """In the colour of what the person does."""
        accent = self.theme.information.ink
        self.ink(accent, width=self.line_px + 1)
        self.line(begin, end)
        self.head(begin, end)

    def head(self, begin: tuple[float, float], end: tuple[float, float]) -> None:
        way = QPointF(end[0] - begin[0], end[1] - begin[1])
        length = max(1e-6, (way.x() ** 2 + way.y() ** 2) ** 0.5)
        x, y = way.x() / length, way.y() / length
        size = 9.0
        tip = QPointF(end[0] + x * 4, end[1] + y * 4)
        left = QPointF(tip.x() - x * size - y * size * 0.6, tip.y() - y * size + x * size * 0.6)
        right = QPointF(tip.x() - x * size + y * size * 0.6, tip.y() - y * size - x * size * 0.6)
        self.painter.setBrush(QColor(self.theme.information.ink))
        self.painter.setPen(Qt.PenStyle.NoPen)
        self.painter.drawPolygon(QPolygonF([tip, left, right]))

    def arc_arrow(self, centre: tuple[float, float], radius: float, begin_deg: float, sweep_deg: float) -> None:
        """Degrees from the right, counter-clockwise."""
        self.ink(self.theme.information.ink, width=self.line_px + 1)
        box = QRectF(centre[0] - radius, centre[1] - radius, 2 * radius, 2 * radius)
        self.painter.drawArc(box, round(16 * begin_deg), round(16 * sweep_deg))
        end, before = radians(begin_deg + sweep_deg), radians(begin_deg + sweep_deg * 0.9)
        at = (centre[0] + radius * cos(end), centre[1] - radius * sin(end))
        self.head((centre[0] + radius * cos(before), centre[1] - radius * sin(before)), at)

    def module(
        self,
        centre: tuple[float, float],
        turn_deg: float = 0.0,
        *,
        is_ghost: bool = False,
        lid_deg: float = 0.0,
        has_nose: bool = False,
    ) -> None:
        """The module with the lid of its bay. `turn_deg` clockwise; `has_nose`: its front is at the right."""
        painter, theme = self.painter, self.theme
        painter.save()
        painter.translate(*centre)
        painter.rotate(turn_deg)
        body = QRectF(-_BODY_W / 2, -_BODY_H / 2 + _LID_H, _BODY_W, _BODY_H - _LID_H)
        self.ink(theme.muted if is_ghost else theme.text, is_dashed=is_ghost)
        if not is_ghost:
            painter.setBrush(QColor(theme.surface))
        painter.drawRoundedRect(body, 5, 5)
        painter.save()
        painter.translate(-_BODY_W / 2, -_BODY_H / 2 + _LID_H)
        painter.rotate(-lid_deg)
        painter.drawRoundedRect(QRectF(-3, -_LID_H, _BODY_W + 6, _LID_H), 4, 4)
        painter.restore()
        if has_nose:
            middle, side = body.center().y(), _BODY_W / 2 + 3
            painter.setBrush(QColor(theme.text))
            painter.setPen(Qt.PenStyle.NoPen)
            corners = (QPointF(side, middle - 7), QPointF(side + 10, middle), QPointF(side, middle + 7))
            painter.drawPolygon(QPolygonF(corners))
        painter.restore()

    def ground(self) -> None:
        self.ink(self.theme.border)
        self.line((30.0, 150.0), (250.0, 150.0))

    def text(self, box: QRectF, words: str, *, colour: str = "", is_bold: bool = False) -> None:
        self.painter.setPen(QColor(colour or self.theme.text))
        self.painter.setFont(font(Size.SMALL, is_bold=is_bold))
        self.painter.drawText(box, Qt.AlignmentFlag.AlignCenter, words)

    def hand(self, x: float, y: float) -> None:
        """An open hand from the left, palm up, its finger tips at (x, y)."""
        theme = self.theme
        path = QPainterPath(QPointF(x - 112, y + 26))
        path.cubicTo(QPointF(x - 80, y + 26), QPointF(x - 84, y + 8), QPointF(x - 60, y + 4))
        path.lineTo(QPointF(x - 6, y + 4))
        path.cubicTo(QPointF(x + 2, y + 4), QPointF(x + 2, y + 14), QPointF(x - 6, y + 14))
        path.lineTo(QPointF(x - 30, y + 15))
        path.cubicTo(QPointF(x - 48, y + 18), QPointF(x - 40, y + 40), QPointF(x - 112, y + 46))
        self.ink(theme.text)
        self.painter.setBrush(QColor(theme.raised))
        self.painter.drawPath(path)

    def icon(self, picture: Icon, x: float, y: float, size: float, meaning: Meaning | None = None) -> None:
        colour = self.theme.muted if meaning is None else self.theme.tint(meaning).ink
        draw(self.painter, picture, QRectF(x, y, size, size), colour)


_SIDE, _BEHIND = marked("from the side"), marked("from behind")
_TILTS: Final = {1: (_SIDE, 62.0), 2: (_BEHIND, 62.0), 3: (_SIDE, -62.0), 4: (_BEHIND, -62.0)}
"""By step: from where it is seen, and the turn, clockwise."""


def _tilt(pencil: Pencil, step: int) -> None:
    pencil.ground()
    if step not in _TILTS:
        pencil.module((140, 127), has_nose=True)
        name, meaning = (Icon.ACTIVE, Meaning.DANGER) if step == 0 else (Icon.LOCK, Meaning.GOOD)
        pencil.icon(name, 122, 40, 36, meaning)
        return
    view, turn = _TILTS[step]
    pencil.text(QRectF(4, 4, 110, 18), tr(view), colour=pencil.theme.muted)
    pencil.module((140, 92), is_ghost=True)
    pencil.module((140, 92), turn, has_nose=view == _SIDE)
    begin = 20.0 if turn > 0 else 160.0
    pencil.arc_arrow((140, 92), 76, begin + (30 if turn > 0 else -30), -58 if turn > 0 else 58)


def _free_fall(pencil: Pencil, step: int) -> None:
    theme = pencil.theme
    cushion = QRectF(78, 138, 124, 24)
    pencil.ink(theme.text)
    pencil.painter.setBrush(QColor(theme.tint(Meaning.INFORMATION).wash))
    pencil.painter.drawRoundedRect(cushion, 11, 11)
    pencil.line((112, 144), (118, 150), (112, 156))
    pencil.line((168, 144), (162, 150), (168, 156))
    y = {0: 38.0, 1: 82.0}.get(step, 114.0)
    if step == 0:
        pencil.hand(186, y + 20)
    pencil.module((140, y))
    if step == 1:
        pencil.module((140, 32), is_ghost=True)
        pencil.ink(theme.muted)
        for x in (112.0, 140.0, 168.0):
            pencil.line((x, 40), (x, 46))
        pencil.arrow((140, 110), (140, 128))
    if step < 2:
        pencil.ink(theme.border)
        pencil.line((222, 40), (222, 136))
        pencil.line((216, 40), (228, 40))
        pencil.line((216, 136), (228, 136))
        pencil.text(QRectF(226, 78, 52, 20), "50 cm")


def _bay(pencil: Pencil, step: int) -> None:
    is_open = step >= 1
    pencil.ground()
    pencil.module((140, 127), lid_deg=70.0 if is_open else 0.0)
    if is_open:
        pencil.icon(Icon.LIGHT, 176, 22, 44, Meaning.ATTENTION)
        pencil.ink(pencil.theme.attention.ink, is_dashed=True)
        for shift in (0.0, 18.0, 36.0):
            pencil.line((178 - shift / 2, 66 + shift / 8), (158 - shift * 0.8, 108))
    else:
        pencil.arrow((140, 56), (140, 94))


def _link(pencil: Pencil, step: int) -> None:
    theme = pencil.theme
    pencil.ground()
    pencil.module((202, 127))
    cable = QPainterPath(QPointF(124, 133))
    cable.cubicTo(QPointF(92, 133), QPointF(96, 96), QPointF(64, 100))
    cable.lineTo(QPointF(46, 100))
    pencil.ink(theme.text)
    pencil.painter.drawPath(cable)
    pencil.painter.setBrush(QColor(theme.surface))
    pencil.painter.drawRoundedRect(QRectF(124, 122, 34, 22), 5, 5)
    pencil.painter.drawRoundedRect(QRectF(14, 84, 34, 32), 4, 4)
    pencil.text(QRectF(14, 84, 34, 32), "USB")
    if step >= 1:
        pencil.arrow((141, 110), (141, 82))
        pencil.arrow((141, 82), (141, 108))
        pencil.arrow((118, 66), (92, 66))
        pencil.arrow((92, 66), (118, 66))


_PICTURES: Final[Mapping[GuidedKind, Callable[[Pencil, int], None]]] = {
    GuidedKind.TILT: _tilt,
    GuidedKind.FREE_FALL: _free_fall,
    GuidedKind.BAY: _bay,
    GuidedKind.LINK: _link,
}


def paint_picture(painter: QPainter, box: QRectF, kind: GuidedKind, step: int) -> None:
    """As large as it fits into `box`, in its middle."""
    scale = min(box.width() / WIDTH, box.height() / HEIGHT)
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.translate(box.center())
    painter.scale(scale, scale)
    painter.translate(-WIDTH / 2, -HEIGHT / 2)
    _PICTURES[kind](Pencil(painter), step)
    painter.restore()


def ground(theme: Theme) -> QColor:
    """Behind the picture."""
    return QColor(theme.surface)
