"""Tilt gauge, 0 to 180°.

The right arm of the aircraft is the needle: 0° is at the right, 90° at the top, 180° at the left. Beyond the attitude
threshold the arc shows where the module fires; a mark before it shows where the trigger rearms. The numbers are beside
it.
"""

import math
from collections.abc import Hashable
from typing import ClassVar, Final

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPaintEvent, QPixmap

from app.safety.last_known import TRIGGER_NOT_KNOWN
from app.text.i18n import tr
from app.text.messages import in_brackets
from ui.style.theme import Meaning, Size, Theme, current, font
from ui.widgets.readout import Freshness, PaintedWidget, cleared_word, hatch, pen

_ARM: Final = 0.6
"""Length of an arm as a part of the radius."""
_DISC: Final = 0.74
"""Radius of the disc as a part of the arc's."""
_EDGE_PX: Final = 4


def stroke_px(theme: Theme, radius: float) -> float:
    return max(2.0, radius / 26) * (1.0 if theme.line_px == 1 else 1.3)


def draw_aircraft(painter: QPainter, theme: Theme, radius: float, ink: QColor) -> None:
    """Draws it from behind, level; rotate the painter for a tilt."""
    arm = radius * _ARM
    stroke = pen(ink, stroke_px(theme, radius))
    stroke.setCapStyle(Qt.PenCapStyle.RoundCap)
    painter.setPen(stroke)
    painter.drawLine(QPointF(-arm, 0), QPointF(arm, 0))
    for side in (-1, 1):
        hub = side * arm * 0.86
        painter.drawLine(QPointF(hub, 0), QPointF(hub, -radius * 0.1))
        painter.drawLine(QPointF(hub - radius * 0.17, -radius * 0.1), QPointF(hub + radius * 0.17, -radius * 0.1))
        painter.drawLine(QPointF(side * radius * 0.1, radius * 0.07), QPointF(side * radius * 0.17, radius * 0.2))
    painter.setBrush(QColor(theme.surface))
    painter.drawRoundedRect(QRectF(-radius * 0.17, -radius * 0.1, radius * 0.34, radius * 0.18), 5, 5)


class TiltGauge(PaintedWidget):
    """Unknown and without a threshold at first. Degrees outside 0 to 180 are drawn at the end of the scale."""

    usual: ClassVar = QSize(84, 76)

    def __init__(self) -> None:
        super().__init__()
        self.freshness = Freshness.UNKNOWN
        self._tilt_deg: float | None = None
        self._age = ""
        self._threshold: tuple[float | None, float | None, bool] = (None, None, False)
        """From where it fires and below which it rearms; whether it is not known that it acts on that."""
        self._face = QPixmap()
        self._face_of: Hashable = None
        self._changed()

    def set_threshold(self, fire_deg: float | None, *, reset_deg: float | None = None, is_stale: bool = False) -> None:
        """The tilt from which the module fires, and the one below which it rearms; None: not known, not drawn."""
        if (fire_deg, reset_deg, is_stale) != self._threshold:
            self._threshold = fire_deg, reset_deg, is_stale
            self._changed()

    def show_tilt(self, tilt_deg: float | None, *, stale_age: str = "") -> None:
        """The tilt, None if unknown, and its age in words if it is stale."""
        if (tilt_deg, stale_age) != (self._tilt_deg, self._age):
            self._tilt_deg, self._age = tilt_deg, stale_age
            known = Freshness.STALE if stale_age else Freshness.FRESH
            self.freshness = Freshness.UNKNOWN if tilt_deg is None else known
            self._changed()

    def _changed(self) -> None:
        fire_deg, _, is_stale = self._threshold
        name = f"{tr('Tilt')}: "
        name += tr("unknown") if self._tilt_deg is None else f"{self._tilt_deg:g}°"
        if self._age:
            name += f", {self._age}"
        if fire_deg is not None:
            name += f", {tr('{value}° fires', value=f'{fire_deg:g}')}"
            name += in_brackets(tr(TRIGGER_NOT_KNOWN)) if is_stale else ""
        self.announce(name, name=tr("Tilt"))
        self.setToolTip(name)

    def width_for(self, height: int) -> int:
        return round(2 * (height - _EDGE_PX - 6) / (1 + _DISC) + 2 * _EDGE_PX)

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current()
        painter = self.begin_paint()
        radius = max(20.0, min(self.width() / 2 - _EDGE_PX, (self.height() - _EDGE_PX - 6) / (1 + _DISC)))
        centre = QPointF(self.width() / 2, _EDGE_PX + radius)
        self._draw_face(theme, radius, centre)
        painter.drawPixmap(0, 0, self._face)
        painter.translate(centre)
        if self._tilt_deg is None:
            cleared_word(painter, theme, _square(radius * _DISC), "?", font(Size.BODY, is_bold=True))
        else:
            self._paint_aircraft(painter, theme, radius, self._tilt_deg)
        painter.end()

    def _draw_face(self, theme: Theme, radius: float, centre: QPointF) -> None:
        """Everything that does not move with the tilt, kept as a picture."""
        ratio = self.devicePixelRatioF()
        face_of = theme, ratio, self.size(), self.freshness, self._threshold
        if face_of != self._face_of:
            self._face_of, self._face = face_of, QPixmap(self.size() * ratio)
            self._face.setDevicePixelRatio(ratio)
            self._face.fill(Qt.GlobalColor.transparent)
            painter = QPainter(self._face)
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.translate(centre)
            self._paint_ground(painter, theme, radius * _DISC)
            self._paint_scale(painter, theme, radius)
            painter.end()

    def _paint_ground(self, painter: QPainter, theme: Theme, radius: float) -> None:
        disc, ground = QPainterPath(), QPainterPath()
        disc.addEllipse(_square(radius))
        painter.fillPath(disc, QColor(theme.surface))
        if self.freshness is Freshness.UNKNOWN:
            hatch(painter, disc, theme.divider if theme.line_px == 1 else theme.muted)
            painter.setPen(pen(theme.border, theme.border_px, is_dashed=True))
        else:
            ground.arcTo(_square(radius), 0, -180)
            painter.fillPath(ground, QColor(theme.sunken))
            painter.setPen(pen(theme.border, theme.border_px))
            painter.drawLine(QPointF(-radius, 0), QPointF(radius, 0))
            painter.setPen(pen(theme.divider, theme.border_px, is_dashed=self.freshness is Freshness.STALE))
        painter.drawPath(disc)

    def _paint_scale(self, painter: QPainter, theme: Theme, radius: float) -> None:
        painter.setPen(pen(theme.border, theme.border_px))
        painter.drawArc(_square(radius), 0, 180 * 16)
        for degrees in range(0, 181, 15):
            painter.drawLine(_at(degrees, radius), _at(degrees, radius - (4 if degrees % 45 else 8)))
        fire_deg, reset_deg, is_stale = self._threshold
        if fire_deg is not None:
            fire, ink = _clamped(fire_deg), theme.muted if is_stale else theme.tint(Meaning.DANGER).ink
            painter.setPen(pen(ink, 3.0 + theme.line_px, is_dashed=is_stale))
            painter.drawArc(_square(radius), round(fire * 16), round((180 - fire) * 16))
            painter.setPen(pen(ink, 1.0 + theme.line_px))
            painter.drawLine(_at(fire, radius + 4), _at(fire, radius * _DISC + 3))
        if reset_deg is not None:
            reset, ink = _clamped(reset_deg), theme.muted if is_stale else theme.tint(Meaning.INFORMATION).ink
            painter.setPen(pen(ink, 1.0 + theme.line_px))
            painter.drawLine(_at(reset, radius + 2), _at(reset, radius - 8))

    def _paint_aircraft(self, painter: QPainter, theme: Theme, radius: float, tilt_deg: float) -> None:
        """Rotated by the tilt, with a needle from its right arm to the scale."""
        fire_deg, _, is_stale = self._threshold
        fires = fire_deg is not None and not is_stale and tilt_deg >= fire_deg
        ink = theme.ink(Meaning.DANGER if fires else None)
        if self.freshness is Freshness.STALE:
            ink = QColor(theme.muted)
        painter.rotate(-_clamped(tilt_deg))
        painter.setPen(pen(ink, stroke_px(theme, radius) * 0.7, is_dashed=True))
        painter.drawLine(QPointF(radius * _ARM + 3, 0), QPointF(radius - 10, 0))
        needle = QPainterPath(QPointF(radius - 2, 0))
        needle.lineTo(radius - 12, -5)
        needle.lineTo(radius - 12, 5)
        painter.fillPath(needle, ink)
        draw_aircraft(painter, theme, radius, ink)


def _square(radius: float) -> QRectF:
    """Around the middle."""
    return QRectF(-radius, -radius, 2 * radius, 2 * radius)


def _clamped(degrees: float) -> float:
    return min(180.0, max(0.0, degrees))


def _at(degrees: float, radius: float) -> QPointF:
    angle = math.radians(degrees)
    return QPointF(radius * math.cos(angle), -radius * math.sin(angle))
