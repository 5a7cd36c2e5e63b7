"""Pictures of what makes the module fire: tilt, free fall, or a command."""

import math
from collections.abc import Callable
from typing import ClassVar, Final

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPainterPath, QPaintEvent
from PySide6.QtWidgets import QSizePolicy

from app.text.i18n import tr
from protocol.catalogue import RESET_BELOW_THRESHOLD_DEG
from protocol.messages import TriggerRecord
from ui.plots.gauge import draw_aircraft
from ui.style import icons
from ui.style.icons import Icon
from ui.style.painted_widget import PaintedWidget, pen
from ui.style.theme import Meaning, Size, current, font

_BEYOND_DEG: Final = 8.0
"""How far past the threshold the aircraft is drawn; the record does not contain the tilt."""
_TILT_SHARE: Final = 1.25
"""Of the picture of a tilt, which has labels beside it."""
_CENTRE: Final = Qt.AlignmentFlag.AlignCenter


def draw_attitude(painter: QPainter, box: QRectF, threshold_deg: float) -> None:
    """The aircraft past the threshold, which is red; blue is where the trigger rearms."""
    theme = current()
    label = QFontMetricsF(font(Size.SMALL, is_bold=True))
    radius = max(24.0, min(box.height() - label.height() - 12, (box.width() - 80) / 2))
    reset_deg = threshold_deg - RESET_BELOW_THRESHOLD_DEG
    danger, rearm = theme.danger.ink, theme.information.ink
    labels = (
        (threshold_deg, danger, tr("{value}° fires", value=f"{threshold_deg:g}")),
        (reset_deg, rearm, tr("{value}° rearms", value=f"{reset_deg:g}")),
    )
    right = max(
        math.cos(math.radians(degrees)) * (radius + 10) + label.horizontalAdvance(text) + 2
        for degrees, _, text in labels
    )
    painter.save()
    # In the middle, or further left where a label would reach into what is drawn beside it.
    middle = max(box.left() + radius + 3, min(box.center().x(), box.right() - right))
    painter.translate(middle, box.top() + label.height() + 6 + radius)
    arc = QRectF(-radius, -radius, 2 * radius, 2 * radius)
    painter.setPen(pen(theme.border, theme.border_px))
    painter.drawLine(QPointF(-radius, 0), QPointF(radius, 0))
    painter.drawArc(arc, 0, 180 * 16)
    painter.setPen(pen(danger, 3.0 + theme.line_px))
    painter.drawArc(arc, round(threshold_deg * 16), round((180 - threshold_deg) * 16))
    for degrees, colour, text in labels:
        way = QPointF(math.cos(math.radians(degrees)), -math.sin(math.radians(degrees)))
        painter.setPen(pen(colour, 1.0 + theme.line_px))
        painter.drawLine(way * (radius - 6), way * (radius + 6))
        # One label above the arc, one beside it, so that they never overlap.
        is_upper = degrees == threshold_deg
        place = way * (radius + 10)
        width = label.horizontalAdvance(text) + 2
        room = QRectF(place.x(), place.y() - label.height() * (0.9 if is_upper else 0.1), width, label.height())
        painter.setFont(font(Size.SMALL, is_bold=True))
        painter.drawText(room, _CENTRE | Qt.TextFlag.TextDontClip, text)
    painter.rotate(-min(180.0, threshold_deg + _BEYOND_DEG))
    draw_aircraft(painter, theme, radius * 0.95, QColor(danger))
    painter.restore()


def draw_free_fall(painter: QPainter, box: QRectF, below_g: float, for_s: float) -> None:
    """The aircraft falling level, with acceleration and time as text."""
    theme = current()
    words = font(Size.SMALL, is_bold=True)
    metrics = QFontMetricsF(words)
    text = tr("below {g} g for {time} s", g=f"{below_g:.1f}", time=f"{for_s:.2f}")
    line = metrics.height() * (1 if metrics.horizontalAdvance(text) < box.width() else 2)
    radius = max(24.0, min((box.height() - line) * 0.62, box.width() / 2.6))
    centre = QPointF(box.center().x(), box.top() + (box.height() - line) * 0.42)
    danger = QColor(theme.danger.ink)
    painter.setPen(pen(theme.muted, 1.0 + theme.line_px))
    for x in (-0.45, 0.0, 0.45):
        top = QPointF(centre.x() + x * radius, box.top() + 4)
        painter.drawLine(top, QPointF(top.x(), centre.y() - radius * 0.3))
    painter.save()
    painter.translate(centre)
    draw_aircraft(painter, theme, radius * 0.95, danger)
    painter.restore()
    _arrow_down(painter, QPointF(centre.x(), centre.y() + radius * 0.3), radius * 0.36, danger)
    painter.setFont(words)
    painter.setPen(danger)
    room = QRectF(box.left(), box.bottom() - line, box.width(), line)
    painter.drawText(room, _CENTRE | Qt.TextFlag.TextWordWrap, text)


def _arrow_down(painter: QPainter, top: QPointF, length: float, colour: QColor) -> None:
    tip = QPointF(top.x(), top.y() + length)
    painter.setPen(pen(colour, 2.0))
    painter.drawLine(top, tip)
    head = QPainterPath(tip)
    head.lineTo(tip.x() - 6, tip.y() - 8)
    head.lineTo(tip.x() + 6, tip.y() - 8)
    head.closeSubpath()
    painter.fillPath(head, colour)


def _draw_command(painter: QPainter, box: QRectF, picture: Icon) -> None:
    side = min(48.0, box.height() * 0.5)
    square = QRectF(box.center().x() - side / 2, box.center().y() - side / 2, side, side)
    icons.draw(painter, picture, square, current().ink(Meaning.DANGER))


class TriggerPicture(PaintedWidget):
    """Draws the causes in a trigger record side by side."""

    usual: ClassVar = QSize(280, 96)
    least: ClassVar = QSize(0, 0)

    def __init__(self, name: str) -> None:
        super().__init__()
        self.setObjectName(name)
        self._record: TriggerRecord | None = None
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.use_card_background()

    def show_record(self, record: TriggerRecord | None, words: str) -> None:
        """`words`: the causes, for screen readers."""
        self._record = record
        self.announce(words)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = self.begin_paint()
        parts = self._parts()
        left, whole = 0.0, sum(share for share, _ in parts)
        for share, draw in parts:
            width = self.width() * share / whole
            draw(painter, QRectF(left, 0, width, self.height()))
            left += width
        painter.end()

    def _parts(self) -> list[tuple[float, Callable[[QPainter, QRectF], None]]]:
        """The share in the width of each cause of the record, and what draws it."""
        record = self._record
        if record is None:
            return []
        known: dict[str, Callable[[QPainter, QRectF], None]] = {
            "attitude": lambda painter, box: draw_attitude(painter, box, record.attitude_threshold_deg),
            "freefall": lambda painter, box: draw_free_fall(
                painter, box, record.freefall_acceleration_g, record.freefall_time_s
            ),
            "serial": lambda painter, box: _draw_command(painter, box, Icon.LINK),
            "pwm": lambda painter, box: _draw_command(painter, box, Icon.PLUG),
        }
        return [(_TILT_SHARE if one == "attitude" else 1.0, known[one]) for one in record.sources if one in known]
