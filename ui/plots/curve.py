"""The curve of a lane.

It gets new points at every draw, from an envelope of at most a thousand buckets. Pens are cosmetic, one pixel wide and
without antialiasing: anything else costs several times as much.
"""

from itertools import pairwise
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF
from shiboken6 import VoidPtr

from app.samples.ring_buffers import Envelope
from ui.plots.view import Lane, Scale, Span, fitting_scale
from ui.style.theme import Theme

MAX_BUCKETS: Final = 1000
# One and a half logical pixels at 200 %; with a fourth copy a draw would take longer than 10 ms.
_MAX_COPIES: Final = 3


class Points(NamedTuple):
    """Times and values with NaN where the curve is interrupted, and the gaps."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    gaps: list[Span]


def points(envelope: Envelope, *, origin_s: float, gap_s: float) -> Points:
    """Connects the lowest and the highest value of each bucket, interrupted where samples are missing."""
    count = len(envelope.low)
    x = np.empty((count, 2))
    y = np.empty((count, 2))
    x[:, 0], x[:, 1] = envelope.start_s, envelope.end_s
    y[:, 0], y[:, 1] = envelope.low, envelope.high
    x -= origin_s
    breaks = np.flatnonzero(envelope.start_s[1:] - envelope.end_s[:-1] > gap_s)
    gaps = [Span(float(envelope.end_s[n]), float(envelope.start_s[n + 1])) for n in breaks]
    places = (breaks + 1) * 2
    flat_x, flat_y = x.ravel(), y.ravel()
    if len(places):
        flat_x = np.insert(flat_x, places, np.nan)
        flat_y = np.insert(flat_y, places, np.nan)
    return Points(flat_x, flat_y, gaps)


def _line(x: NDArray[np.float64], y: NDArray[np.float64]) -> QPolygonF:
    """A polygon filled through its memory, which is a hundred times as fast as point by point."""
    line = QPolygonF()
    line.resize(len(x))
    if len(x):
        memory: Any = VoidPtr(line.data(), len(x) * 16, True)  # type: ignore[call-arg, arg-type]  # wrongly declared
        places: NDArray[np.float64] = np.frombuffer(memory, np.float64)
        places[::2], places[1::2] = x, y
    return line


class LaneCurve:
    """Position and curve of a lane, in pixels of the canvas."""

    def __init__(self, lane: Lane, number: int) -> None:
        self.lane = lane
        self.number = number
        self.box = QRectF()
        self.scale: Scale = lane.scales[0]
        self._least_scale = 0
        self.gaps: list[Span] = []
        self._line_px = 1
        self._pen = QPen()
        self._lines: list[QPolygonF] = []

    def apply_theme(self, theme: Theme) -> None:
        self._pen = QPen(QColor(theme.curves[self.number % len(theme.curves)]), 1)
        self._pen.setCosmetic(True)
        self._pen.setCapStyle(Qt.PenCapStyle.SquareCap)
        self._line_px = theme.line_px

    def fit_scale(self) -> None:
        """Lets the next draw choose a smaller scale; otherwise the scale only grows."""
        self._least_scale = 0

    def place(self, box: QRectF) -> None:
        self.box = box

    def draw(self, span: Span) -> None:
        """Computes the lines of a time span."""
        lane = self.lane
        buckets = min(MAX_BUCKETS, max(50, int(self.box.width())))
        envelope = lane.series.decimated(span.start_s, span.end_s, buckets)
        what = points(envelope, origin_s=span.start_s, gap_s=lane.gap_s)
        newest = lane.series.last
        if newest is not None and newest.time_s < span.end_s - lane.gap_s:
            what.gaps.append(Span(newest.time_s, span.end_s))
        self.gaps = what.gaps
        self.scale = scale = fitting_scale(lane.scales[self._least_scale :], *self._extremes(envelope, span))
        self._least_scale = lane.scales.index(scale)
        x = self.box.left() + what.x * (self.box.width() / span.length_s)
        y = self.box.bottom() - (what.y - scale.low) * (self.box.height() / (scale.high - scale.low))
        breaks = [-1, *np.flatnonzero(np.isnan(x)).tolist(), len(x)] if what.gaps else [-1, len(x)]
        self._lines = [_line(x[before + 1 : at], y[before + 1 : at]) for before, at in pairwise(breaks)]

    def paint(self, painter: QPainter, *, ratio: float) -> None:
        """Paints the lines; `ratio`: device pixels per logical pixel."""
        painter.save()
        painter.setClipRect(self.box)
        painter.setPen(self._pen)
        # Shifted copies of a line are far cheaper than a wider pen.
        for _ in range(min(_MAX_COPIES, max(1, round(self._line_px * ratio)))):
            for line in self._lines:
                painter.drawPolyline(line)
            painter.translate(1 / ratio, 1 / ratio)
        painter.restore()

    def _extremes(self, envelope: Envelope, span: Span) -> tuple[float, float]:
        """Lowest and highest of the samples and limits in sight."""
        seen = [
            change.value
            for limit in self.lane.limits
            for steps in (limit.steps, limit.stale)
            if steps is not None
            for change in steps.between(span.start_s, span.end_s)
            if change.value is not None
        ]
        if len(envelope.low):
            seen += [float(envelope.low.min()), float(envelope.high.max())]
        lowest, highest = self.lane.scales[0].low, self.lane.scales[0].high
        return (min(seen, default=lowest), max(seen, default=highest))

    def x(self, time_s: float, span: Span) -> float:
        """The x coordinate of a time."""
        return self.box.left() + (time_s - span.start_s) / span.length_s * self.box.width()

    def y(self, value: float) -> float:
        """The y coordinate of a value, clamped to the scale."""
        part = (value - self.scale.low) / (self.scale.high - self.scale.low)
        return self.box.bottom() - min(1.0, max(0.0, part)) * self.box.height()
