"""A multicopter seen from behind, around the painter's origin."""

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter

from ui.style.shapes import pen
from ui.style.theme import Theme

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
