"""Tilt gauge, 0 to 180°.

The right arm of the aircraft is the needle: 0° is at the right, 90° at the top, 180° at the left. Beyond the attitude
threshold the arc shows where the module fires; a mark before it shows where the trigger rearms.
"""

import math
from collections.abc import Hashable
from typing import Final

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPainterPath, QPaintEvent, QPixmap
from PySide6.QtWidgets import QSizePolicy

from app.text.i18n import tr
from app.text.sentences import in_brackets
from ui.style.painted_widget import Freshness, PaintedWidget, cleared_word, hatch, pen
from ui.style.theme import Meaning, Size, Theme, current, font

ARM = 0.6
"""Length of an arm as a part of the radius."""


def draw_aircraft(painter: QPainter, theme: Theme, radius: float, ink: QColor) -> None:
    """Draws it level; rotate the painter for a tilt."""
    arm = radius * ARM
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


def stroke_px(theme: Theme, radius: float) -> float:
    return max(2.0, radius / 26) * (1.0 if theme.line_px == 1 else 1.3)


_LARGEST_DEG: Final = 180.0
# Radius of the disc as a part of the arc's.
_DISC: Final = 0.74


class TiltGauge(PaintedWidget):
    """Unknown and without a threshold at first. Degrees outside 0 to 180 are drawn at the end of the scale. A compact
    gauge has no figures."""

    def __init__(self, *, is_compact: bool = False) -> None:
        super().__init__()
        self._is_compact = is_compact
        self._tilt_deg: float | None = None
        self._fire_deg: float | None = None
        self._reset_deg: float | None = None
        self._is_limit_stale = False
        self.freshness = Freshness.UNKNOWN
        self._age = ""
        self._face = QPixmap()
        self._face_of: Hashable = None
        policy = QSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Preferred)
        policy.setHeightForWidth(True)
        self.setSizePolicy(policy)
        self._changed()

    def set_threshold(self, fire_deg: float | None, *, reset_deg: float | None = None, is_stale: bool = False) -> None:
        """The tilt from which the module fires, and the one below which it rearms; None: not known, not drawn."""
        if (fire_deg, reset_deg, is_stale) != (self._fire_deg, self._reset_deg, self._is_limit_stale):
            self._fire_deg, self._reset_deg, self._is_limit_stale = fire_deg, reset_deg, is_stale
            self._changed()

    def show_tilt(self, tilt_deg: float) -> None:
        """A fresh tilt."""
        self._show(Freshness.FRESH, tilt_deg, "")

    def show_stale(self, tilt_deg: float, age: str) -> None:
        """The last tilt and its age in words."""
        self._show(Freshness.STALE, tilt_deg, age)

    def show_unknown(self) -> None:
        """No tilt."""
        self._show(Freshness.UNKNOWN, None, "")

    def _show(self, freshness: Freshness, tilt_deg: float | None, age: str) -> None:
        if (freshness, tilt_deg, age) != (self.freshness, self._tilt_deg, self._age):
            self.freshness, self._tilt_deg, self._age = freshness, tilt_deg, age
            self._changed()

    def _changed(self) -> None:
        name = f"{tr('Tilt')}: "
        name += tr("unknown") if self._tilt_deg is None else f"{self._tilt_deg:g}°"
        if self._age:
            name += f", {self._age}"
        if self._fire_deg is not None:
            name += f", {tr('{value}° fires', value=f'{self._fire_deg:g}')}"
            if self._is_limit_stale:
                name += in_brackets(tr("stale"))
        self.announce(name, name=tr("Tilt"))
        self.setToolTip(name)

    def sizeHint(self) -> QSize:
        return QSize(232, self.heightForWidth(232))

    def minimumSizeHint(self) -> QSize:
        width = 64 if self._is_compact else 160
        return QSize(width, self.heightForWidth(width))

    def heightForWidth(self, width: int) -> int:
        radius = (width - 2 * self._side()) / 2
        return round(radius * (1 + _DISC) + self._margin() + 6)

    def width_for(self, height: int) -> int:
        """The width at which it fills `height`."""
        return round(2 * (height - self._margin() - 6) / (1 + _DISC) + 2 * self._side())

    def _margin(self) -> float:
        """Room for the labels above the arc."""
        return 4.0 if self._is_compact else QFontMetricsF(font(Size.SMALL)).height() + 8

    def _side(self) -> float:
        """Room for the label beside each end of the arc."""
        return 4.0 if self._is_compact else QFontMetricsF(font(Size.SMALL)).horizontalAdvance("180") + 10

    def _radius(self) -> float:
        by_width = (self.width() - 2 * self._side()) / 2
        by_height = (self.height() - self._margin() - 6) / (1 + _DISC)
        return max(20.0, min(by_width, by_height))

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current()
        painter = self.begin_paint()
        radius = self._radius()
        painter.drawPixmap(0, 0, self._painted_face(theme, radius))
        painter.translate(self.width() / 2, self._margin() + radius)
        if self._tilt_deg is None:
            disc = QRectF(-radius * _DISC, -radius * _DISC, 2 * radius * _DISC, 2 * radius * _DISC)
            cleared_word(
                painter, theme, disc, "?" if self._is_compact else tr("unknown"), font(Size.BODY, is_bold=True)
            )
        else:
            self._paint_aircraft(painter, theme, radius, self._tilt_deg)
        if self._age and not self._is_compact:
            below = QRectF(-radius, radius * 0.36, 2 * radius, 24)
            cleared_word(painter, theme, below, self._age, font(Size.SMALL, is_bold=True))
        painter.end()

    def _painted_face(self, theme: Theme, radius: float) -> QPixmap:
        """Everything that does not move with the tilt, as a cached pixmap."""
        ratio = self.devicePixelRatioF()
        small = font(Size.SMALL).key()
        face_of = (
            theme.name,
            small,
            ratio,
            self.size(),
            self.freshness,
            self._fire_deg,
            self._reset_deg,
            self._is_limit_stale,
        )
        if face_of != self._face_of:
            self._face_of, self._face = face_of, QPixmap(self.size() * ratio)
            self._face.setDevicePixelRatio(ratio)
            self._face.fill(Qt.GlobalColor.transparent)
            painter = QPainter(self._face)
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.translate(self.width() / 2, self._margin() + radius)
            self._paint_ground(painter, theme, radius)
            self._paint_scale(painter, theme, radius)
            painter.end()
        return self._face

    def _paint_ground(self, painter: QPainter, theme: Theme, radius: float) -> None:
        """The disc with sky and ground."""
        inner = radius * _DISC
        disc = QPainterPath()
        disc.addEllipse(QPointF(0, 0), inner, inner)
        painter.fillPath(disc, QColor(theme.surface))
        if self.freshness is Freshness.UNKNOWN:
            hatch(painter, disc, theme.divider if theme.line_px == 1 else theme.muted)
            painter.setPen(pen(theme.border, theme.border_px, is_dashed=True))
            painter.drawPath(disc)
            return
        ground = QPainterPath()
        ground.moveTo(inner, 0)
        ground.arcTo(QRectF(-inner, -inner, 2 * inner, 2 * inner), 0, -180)
        ground.closeSubpath()
        painter.fillPath(ground, QColor(theme.sunken))
        painter.setPen(pen(theme.border, theme.border_px))
        painter.drawLine(QPointF(-inner, 0), QPointF(inner, 0))
        painter.setPen(pen(theme.divider, theme.border_px, is_dashed=self.freshness is Freshness.STALE))
        painter.drawPath(disc)

    def _paint_scale(self, painter: QPainter, theme: Theme, radius: float) -> None:
        thick = 3.0 + theme.line_px
        box = QRectF(-radius, -radius, 2 * radius, 2 * radius)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(pen(theme.border, theme.border_px))
        painter.drawArc(box, 0, 180 * 16)
        painter.setFont(font(Size.SMALL))
        for degrees in range(0, 181, 15):
            is_labelled = degrees % 45 == 0
            painter.setPen(pen(theme.border, theme.border_px))
            painter.drawLine(_at(degrees, radius), _at(degrees, radius - (8 if is_labelled else 4)))
            if is_labelled and not self._is_compact and not self._is_near_mark(degrees):
                painter.setPen(QColor(theme.muted))
                _label(painter, degrees, radius, f"{degrees}")
        if self._fire_deg is not None:
            fire = _clamped(self._fire_deg)
            colour = theme.muted if self._is_limit_stale else theme.tint(Meaning.DANGER).ink
            painter.setPen(pen(colour, thick, is_dashed=self._is_limit_stale))
            painter.drawArc(box, round(fire * 16), round((_LARGEST_DEG - fire) * 16))
            painter.setPen(pen(colour, 1.0 + theme.line_px))
            painter.drawLine(_at(fire, radius + 4), _at(fire, radius * _DISC + 3))
            painter.setFont(font(Size.SMALL, is_bold=True))
            self._label(painter, fire + self._apart_deg(), radius, f"{self._fire_deg:g}°")
        if self._reset_deg is not None:
            reset = _clamped(self._reset_deg)
            painter.setPen(
                pen(theme.muted if self._is_limit_stale else theme.tint(Meaning.INFORMATION).ink, 1.0 + theme.line_px)
            )
            painter.drawLine(_at(reset, radius + 2), _at(reset, radius - 8))
            painter.setFont(font(Size.SMALL))
            self._label(painter, reset - self._apart_deg(), radius, f"{self._reset_deg:g}°")

    def _label(self, painter: QPainter, degrees: float, radius: float, text: str) -> None:
        if not self._is_compact:
            _label(painter, degrees, radius, text)

    def _apart_deg(self) -> float:
        """How far the labels of the two marks move apart, so that they do not touch."""
        if self._fire_deg is None or self._reset_deg is None:
            return 0.0
        return max(0.0, (18 - (self._fire_deg - self._reset_deg)) / 2)

    def _is_near_mark(self, degrees: float) -> bool:
        marks = (mark for mark in (self._fire_deg, self._reset_deg) if mark is not None)
        return any(abs(mark - degrees) < 12 for mark in marks)

    def _paint_aircraft(self, painter: QPainter, theme: Theme, radius: float, tilt_deg: float) -> None:
        """A multicopter from behind, rotated by the tilt, with a needle from its right arm to the scale."""
        is_stale = self.freshness is Freshness.STALE
        fires = self._fire_deg is not None and not self._is_limit_stale and tilt_deg >= self._fire_deg
        ink = QColor(theme.muted) if is_stale else theme.ink(Meaning.DANGER if fires else None)
        arm, width = radius * ARM, stroke_px(theme, radius)
        painter.save()
        painter.rotate(-_clamped(tilt_deg))
        painter.setPen(pen(ink, width * 0.7, is_dashed=True))
        painter.drawLine(QPointF(arm + 3, 0), QPointF(radius - 10, 0))
        needle = QPainterPath(QPointF(radius - 2, 0))
        needle.lineTo(radius - 12, -5)
        needle.lineTo(radius - 12, 5)
        needle.closeSubpath()
        painter.fillPath(needle, ink)
        draw_aircraft(painter, theme, radius, ink)
        painter.restore()


def _clamped(degrees: float) -> float:
    return min(_LARGEST_DEG, max(0.0, degrees))


def _at(degrees: float, radius: float) -> QPointF:
    angle = math.radians(degrees)
    return QPointF(radius * math.cos(angle), -radius * math.sin(angle))


def _label(painter: QPainter, degrees: float, radius: float, text: str) -> None:
    """A text outside the arc, at the same distance at every angle."""
    metrics = QFontMetricsF(painter.font())
    width, height = metrics.horizontalAdvance(text) + 2, metrics.height()
    angle = math.radians(degrees)
    reach = radius + 6 + abs(math.cos(angle)) * width / 2 + abs(math.sin(angle)) * height / 2
    middle = _at(degrees, reach)
    box = QRectF(middle.x() - width / 2, middle.y() - height / 2, width, height)
    painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)
