"""The axes of the plots: labels of pyqtgraph that never touch each other."""

import math
from typing import Any, Final

import pyqtgraph as pg
from PySide6.QtCore import QRectF
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPen
from PySide6.QtWidgets import QGraphicsItem

from app.system.clock import clock_text
from app.text.i18n import tr
from ui.style.theme import Size, current, font, scaled

# Distances between ticks, in seconds.
_STEPS_S: Final = (
    *(0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5),
    *(1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0, 7200.0),
    *(14400.0, 21600.0, 43200.0),
)
_MARGIN_PX: Final = 60
"""Labels may be as far beyond the ends of an axis."""
_GAP_PX: Final = 4


class LabelAxis(pg.AxisItem):  # type: ignore[misc]
    """An axis of labels only, kept as a picture, which makes a redraw six times as fast."""

    def __init__(self, side: str, view: pg.ViewBox) -> None:
        super().__init__(side, linkView=view)
        self.enableAutoSIPrefix(False)
        self.setStyle(tickLength=0, tickAlpha=0, autoExpandTextSpace=False, maxTickLevel=0)
        self._taken = QRectF()
        self.setCacheMode(QGraphicsItem.CacheMode.DeviceCoordinateCache)

    def apply_theme(self, line: QPen | None) -> None:
        self.setTickFont(font(Size.SMALL))
        self.setTextPen(QColor(current().muted))
        self.setPen(line)

    def boundingRect(self) -> QRectF:
        """Also for labels beyond its ends; that of pyqtgraph takes longer than drawing them."""
        x, y = (0, _MARGIN_PX) if self.orientation == "left" else (_MARGIN_PX, 0)
        return QRectF(self.rect()).adjusted(-x, -y, x, y)

    def keep_off(self, room: QRectF) -> None:
        """Shows no label that would touch a room in the scene."""
        if room != self._taken:
            self._taken, self.picture = room, None
            self.update()

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        return [text.replace("-", "−") for text in super().tickStrings(values, scale, spacing)]

    def generateDrawSpecs(self, painter: QPainter) -> Any:
        """Leaves out labels that would touch others: the last one is the most important, then those from the first
        on. At the left end it would touch those of the axis there: that of the very beginning is moved."""
        specs = super().generateDrawSpecs(painter)
        if specs is None:
            return None
        line, ticks, labels = specs
        rooms, shown = [self.mapRectFromScene(self._taken)], []
        for room, flags, text in (*labels[-1:], *labels[:-1]):
            if self.orientation == "bottom" and room.left() < 0:
                if room.center().x() >= 1:
                    continue
                room.moveLeft(0.0)
            around = room.adjusted(-_GAP_PX / 2, -1, _GAP_PX / 2, 1)
            if not any(around.intersects(other) for other in rooms):
                rooms.append(around)
                shown.append((room, flags, text))
        return line, ticks, shown


class TimeAxis(LabelAxis):
    """Seconds before the end of the time span, or times of day."""

    def __init__(self, view: pg.ViewBox) -> None:
        super().__init__("bottom", view)
        self._end_wall_s: float | None = None
        self._shown: object = None
        self._times: list[float] = []

    def show_span(self, length_s: float, end_wall_s: float | None) -> list[float]:
        """`end_wall_s`: the end of the span in seconds since 1970, for times of day. Returns the times of the ticks."""
        shown = length_s, end_wall_s, self.width(), scaled(Size.SMALL)
        if shown != self._shown:
            self._shown, self._end_wall_s, self.picture = shown, end_wall_s, None
            self._times = self.tickValues(-length_s, 0.0, self.width())[0][1]
            self.update()
        return self._times

    def tickSpacing(self, begin_s: float, end_s: float, _size: float) -> list[tuple[float, float]]:
        """As many as there is room for, at round times."""
        most = max(2, int(self.width() / QFontMetricsF(font(Size.SMALL)).horizontalAdvance("00:00:00.000")))
        step_s = next((step for step in _STEPS_S if int((end_s - begin_s) / step) <= most), _STEPS_S[-1])
        return [(step_s, -(self._end_wall_s or 0.0) % step_s)]

    def tickStrings(self, values: list[float], _scale: float, step_s: float) -> list[str]:
        decimals = max(0, math.ceil(-math.log10(step_s) - 1e-9)) if step_s < 1 else 0
        if self._end_wall_s is None:
            return [_ago(-value, step_s, decimals) for value in values]
        return [clock_text(self._end_wall_s + value, decimals) for value in values]


def ago_text(seconds: float, decimals: int = 1) -> str:
    """A time before now, such as "−5.0 s"."""
    return "−" + tr("{value} s", value=f"{seconds:.{decimals}f}")


def _ago(seconds: float, step_s: float, decimals: int) -> str:
    if seconds < step_s / 2:
        return tr("now")
    if step_s >= 60:
        return "−" + tr("{value:.0f} min", value=seconds / 60)
    return ago_text(seconds, decimals)
