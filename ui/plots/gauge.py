"""Tilt gauge, 0 to 180°.

The right arm of the aircraft is the needle: 0° is at the right, 90° at the top, 180° at the left. Beyond the attitude
threshold the arc shows where the module fires; a mark before it shows where the trigger rearms. The numbers are beside
it.
"""

import math
from typing import ClassVar, Final

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPaintEvent

from app.safety.last_known import TRIGGER_NOT_KNOWN
from app.text.i18n import tr
from app.text.messages import in_brackets
from ui.style.theme import Meaning, Size, current, font
from ui.widgets.readout import Freshness, PaintedWidget, pen

# Parts of the radius of the arc: the disc, and an arm of the aircraft.
_DISC: Final = 0.74
_ARM: Final = 0.6
_EDGE_PX: Final = 4


class TiltGauge(PaintedWidget):
    """Unknown and without a threshold at first. Degrees outside 0 to 180 are drawn at the end of the scale."""

    usual: ClassVar = QSize(84, 76)

    def __init__(self) -> None:
        super().__init__()
        self.freshness = Freshness.UNKNOWN
        self._shown: tuple[object, ...] = ()
        # It paints its card, too: else all that lies below would be painted with each change.
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.show_tilt(None)

    def show_tilt(
        self,
        tilt_deg: float | None,
        *,
        stale_age: str = "",
        fires_deg: float | None = None,
        rearms_deg: float | None = None,
        is_unproven: bool = False,
    ) -> None:
        """The tilt, None if unknown, and its age in words if it is stale; from where the module fires and below which
        tilt it rearms, as far as that is known, and whether it is not known that it acts on that."""
        shown = tilt_deg, stale_age, fires_deg, rearms_deg, is_unproven
        if shown == self._shown:
            return
        self._shown = shown
        self._tilt_deg, self._fires_deg, self._rearms_deg = tilt_deg, fires_deg, rearms_deg
        self._is_unproven = is_unproven
        known = Freshness.STALE if stale_age else Freshness.FRESH
        self.freshness = Freshness.UNKNOWN if tilt_deg is None else known
        said = [f"{tr('Tilt')}: {tr('unknown') if tilt_deg is None else f'{tilt_deg:g}°'}"]
        if stale_age:
            said.append(stale_age)
        if fires_deg is not None:
            fires = tr("{value}° fires", value=f"{fires_deg:g}")
            said.append(fires + (in_brackets(tr(TRIGGER_NOT_KNOWN)) if is_unproven else ""))
        self.announce(", ".join(said), name=tr("Tilt"))
        self.setToolTip(", ".join(said))

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), QColor(current().surface))
        radius = max(20.0, min(self.width() / 2 - _EDGE_PX, (self.height() - _EDGE_PX - 6) / (1 + _DISC)))
        painter.translate(QPointF(self.width() / 2, _EDGE_PX + radius))
        self._paint_disc(painter, radius * _DISC)
        self._paint_scale(painter, radius)
        if self._tilt_deg is None:
            painter.setPen(QColor(current().text))
            painter.setFont(font(Size.BODY, is_bold=True))
            painter.drawText(_square(radius), Qt.AlignmentFlag.AlignCenter, "?")
        else:
            self._paint_aircraft(painter, radius, self._tilt_deg)
        painter.end()

    def _paint_disc(self, painter: QPainter, radius: float) -> None:
        """The ground below the horizon; of an unknown tilt there is none."""
        theme = current()
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(theme.surface))
        painter.drawEllipse(_square(radius))
        if self.freshness is not Freshness.UNKNOWN:
            painter.setBrush(QColor(theme.sunken))
            painter.drawChord(_square(radius), 180 * 16, 180 * 16)
            painter.setPen(pen(theme.border, theme.border_px))
            painter.drawLine(QPointF(-radius, 0), QPointF(radius, 0))
        ink = theme.border if self.freshness is Freshness.UNKNOWN else theme.divider
        painter.setPen(pen(ink, theme.border_px, is_dashed=self.freshness is not Freshness.FRESH))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawEllipse(_square(radius))

    def _paint_scale(self, painter: QPainter, radius: float) -> None:
        theme = current()
        painter.setPen(pen(theme.border, theme.border_px))
        painter.drawArc(_square(radius), 0, 180 * 16)
        for degrees in range(0, 181, 15):
            painter.drawLine(_at(degrees, radius), _at(degrees, radius - (4 if degrees % 45 else 8)))
        if self._fires_deg is not None:
            fires, ink = _clamped(self._fires_deg), theme.tint(Meaning.DANGER).ink
            ink = theme.muted if self._is_unproven else ink
            painter.setPen(pen(ink, 3.0 + theme.line_px, is_dashed=self._is_unproven))
            painter.drawArc(_square(radius), round(fires * 16), round((180 - fires) * 16))
            painter.setPen(pen(ink, 1.0 + theme.line_px))
            painter.drawLine(_at(fires, radius + 4), _at(fires, radius * _DISC + 3))
        if self._rearms_deg is not None:
            rearms, ink = _clamped(self._rearms_deg), theme.tint(Meaning.INFORMATION).ink
            painter.setPen(pen(theme.muted if self._is_unproven else ink, 1.0 + theme.line_px))
            painter.drawLine(_at(rearms, radius + 2), _at(rearms, radius - 8))

    def _paint_aircraft(self, painter: QPainter, radius: float, tilt_deg: float) -> None:
        """Paint it from behind, rotated by the tilt, with a needle from its right arm to the scale."""
        theme = current()
        fires = self._fires_deg is not None and not self._is_unproven and tilt_deg >= self._fires_deg
        ink = theme.ink(Meaning.DANGER if fires else None)
        if self.freshness is Freshness.STALE:
            ink = QColor(theme.muted)
        arm, line_px = radius * _ARM, max(2.0, radius / 26) * (1.0 if theme.line_px == 1 else 1.3)
        painter.rotate(-_clamped(tilt_deg))
        painter.setPen(pen(ink, line_px * 0.7, is_dashed=True))
        painter.drawLine(QPointF(arm + 3, 0), QPointF(radius - 10, 0))
        needle = QPainterPath(QPointF(radius - 2, 0))
        needle.lineTo(radius - 12, -5)
        needle.lineTo(radius - 12, 5)
        painter.fillPath(needle, ink)
        stroke = pen(ink, line_px)
        stroke.setCapStyle(Qt.PenCapStyle.RoundCap)
        painter.setPen(stroke)
        painter.drawLine(QPointF(-arm, 0), QPointF(arm, 0))
        for side in (-1, 1):
            hub, up = side * arm * 0.86, -radius * 0.1
            painter.drawLine(QPointF(hub, 0), QPointF(hub, up))
            painter.drawLine(QPointF(hub - radius * 0.17, up), QPointF(hub + radius * 0.17, up))
            painter.drawLine(QPointF(side * radius * 0.1, radius * 0.07), QPointF(side * radius * 0.17, radius * 0.2))
        painter.setBrush(QColor(theme.surface))
        painter.drawRoundedRect(QRectF(-radius * 0.17, -radius * 0.1, radius * 0.34, radius * 0.18), 5, 5)


def _square(radius: float) -> QRectF:
    """Around the middle."""
    return QRectF(-radius, -radius, 2 * radius, 2 * radius)


def _clamped(degrees: float) -> float:
    return min(180.0, max(0.0, degrees))


def _at(degrees: float, radius: float) -> QPointF:
    angle = math.radians(degrees)
    return QPointF(radius * math.cos(angle), -radius * math.sin(angle))
