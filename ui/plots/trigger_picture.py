"""Pictures of what makes the module fire: tilt, free fall, or a command."""

import math
from collections.abc import Callable
from functools import partial
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
_CENTRE: Final = Qt.AlignmentFlag.AlignCenter


def _draw_tilt(painter: QPainter, box: QRectF, record: TriggerRecord) -> None:
    """The aircraft past the threshold, which is red; blue is where the trigger rearms."""
    theme, metrics, fires_deg = current(), QFontMetricsF(painter.font()), record.attitude_threshold_deg
    radius = max(24.0, min(box.height() - metrics.height() - 12, (box.width() - 80) / 2))
    rearms_deg = fires_deg - RESET_BELOW_THRESHOLD_DEG
    # One label above the arc, one beside it, so that they never overlap.
    labels = (
        (fires_deg, 0.9, theme.danger.ink, tr("{value}° fires", value=f"{fires_deg:g}")),
        (rearms_deg, 0.1, theme.information.ink, tr("{value}° rearms", value=f"{rearms_deg:g}")),
    )
    ways = [QPointF(math.cos(math.radians(degrees)), -math.sin(math.radians(degrees))) for degrees, *_ in labels]
    widths = [metrics.horizontalAdvance(text) + 2 for *_, text in labels]
    right = max(way.x() * (radius + 10) + width for way, width in zip(ways, widths, strict=True))
    # In the middle, or further left where a label would reach into what is drawn beside it.
    middle = max(box.left() + radius + 3, min(box.center().x(), box.right() - right))
    painter.translate(middle, box.top() + metrics.height() + 6 + radius)
    arc = QRectF(-radius, -radius, 2 * radius, 2 * radius)
    painter.setPen(pen(theme.border, theme.border_px))
    painter.drawLine(QPointF(-radius, 0), QPointF(radius, 0))
    painter.drawArc(arc, 0, 180 * 16)
    painter.setPen(pen(theme.danger.ink, 3.0 + theme.line_px))
    painter.drawArc(arc, round(fires_deg * 16), round((180 - fires_deg) * 16))
    for (_, above, colour, text), way, width in zip(labels, ways, widths, strict=True):
        painter.setPen(pen(colour, 1.0 + theme.line_px))
        painter.drawLine(way * (radius - 6), way * (radius + 6))
        place = way * (radius + 10) - QPointF(0, metrics.height() * above)
        room = QRectF(place.x(), place.y(), width, metrics.height())
        painter.drawText(room, _CENTRE | Qt.TextFlag.TextDontClip, text)
    painter.rotate(-min(180.0, fires_deg + _BEYOND_DEG))
    draw_aircraft(painter, theme, radius * 0.95, QColor(theme.danger.ink))


def _draw_fall(painter: QPainter, box: QRectF, record: TriggerRecord) -> None:
    theme, metrics = current(), QFontMetricsF(painter.font())
    danger = QColor(theme.danger.ink)
    text = tr(
        "below {g} g for {time} s", g=f"{record.freefall_acceleration_g:.1f}", time=f"{record.freefall_time_s:.2f}"
    )
    line = metrics.height() * (1 if metrics.horizontalAdvance(text) < box.width() else 2)
    radius = max(24.0, min((box.height() - line) * 0.62, box.width() / 2.6))
    painter.setPen(danger)
    room = QRectF(box.left(), box.bottom() - line, box.width(), line)
    painter.drawText(room, _CENTRE | Qt.TextFlag.TextWordWrap, text)
    centre = QPointF(box.center().x(), box.top() + (box.height() - line) * 0.42)
    painter.translate(centre)
    painter.setPen(pen(theme.muted, 1.0 + theme.line_px))
    for x in (-0.45 * radius, 0.0, 0.45 * radius):
        painter.drawLine(QPointF(x, box.top() + 4 - centre.y()), QPointF(x, -radius * 0.3))
    draw_aircraft(painter, theme, radius * 0.95, danger)
    tip = QPointF(0, radius * 0.66)
    painter.setPen(pen(danger, 2.0))
    painter.drawLine(QPointF(0, radius * 0.3), tip)
    head = QPainterPath(tip)
    head.lineTo(tip + QPointF(-6, -8))
    head.lineTo(tip + QPointF(6, -8))
    painter.fillPath(head, danger)


def _draw_command(painter: QPainter, box: QRectF, _record: TriggerRecord, *, picture: Icon) -> None:
    square = QRectF(QPointF(), QSize(1, 1) * min(48.0, box.height() * 0.5))
    square.moveCenter(box.center())
    icons.draw(painter, picture, square, current().ink(Meaning.DANGER))


_DRAWN: Final[dict[str, tuple[float, Callable[[QPainter, QRectF, TriggerRecord], None]]]] = {
    "attitude": (1.25, _draw_tilt),  # it has labels beside it
    "freefall": (1.0, _draw_fall),
    "serial": (1.0, partial(_draw_command, picture=Icon.LINK)),
    "pwm": (1.0, partial(_draw_command, picture=Icon.PLUG)),
}
"""The share in the width of each cause, and what draws it."""


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
        painter, record = self.begin_paint(), self._record
        if record is not None:
            parts = [_DRAWN[cause] for cause in record.sources if cause in _DRAWN]
            left, whole = 0.0, sum(share for share, _ in parts)
            for share, draw in parts:
                width = self.width() * share / whole
                painter.save()
                painter.setFont(font(Size.SMALL, is_bold=True))
                draw(painter, QRectF(left, 0, width, self.height()), record)
                painter.restore()
                left += width
        painter.end()
