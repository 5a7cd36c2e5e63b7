"""One lane on the canvas: an item with grid, limits and curve, the axis of its values, and its words.

Times are kept relative to the end of the span: all but the curve stands still while it follows, and is made once.
"""

from typing import Final, NamedTuple, TypeVar

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QLineF, QPointF, QRectF
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPen
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from app.samples.ring_buffers import Envelope
from app.samples.step_function import StepFunction
from app.text.i18n import tr
from ui.plots.axis import EDGE_PX, LabelAxis
from ui.plots.lanes import Lane, Limit, Scale, Span, fitting_scale, value_text
from ui.plots.overlay import Overlay
from ui.style.painted_widget import pen
from ui.style.theme import current

_MAX_BUCKETS: Final = 1000
# One and a half logical pixels at 200 %; more would take longer than a person notices.
_MAX_PX: Final = 3
_FURTHEST_PX: Final = 60
"""The label of a limit from its line."""
_DRAFT_DASHES: Final = [9, 3, 2, 3]
_STALE_DASHES: Final = [1, 4]
"""Distinguishable from the module's own limits without colour."""


Place = TypeVar("Place", float, NDArray[np.float64])


class Points(NamedTuple):
    """A curve: `connect` says which points are joined to the next, "all" without gaps. Times in seconds after an
    origin, those of `gaps` too."""

    time_s: NDArray[np.float64]
    value: NDArray[np.float64]
    connect: NDArray[np.bool_] | str
    gaps: list[Span]


def points(envelope: Envelope, *, origin_s: float, gap_s: float) -> Points:
    """Joins the lowest and the highest value of each bucket, interrupted where samples are missing."""
    times = np.array((envelope.start_s, envelope.end_s)).T - origin_s
    values = np.array((envelope.low, envelope.high), np.float64).T.ravel()
    breaks = (times[1:, 0] - times[:-1, 1] > gap_s).nonzero()[0]
    if not len(breaks):
        return Points(times.ravel(), values, "all", [])
    connect = np.ones(len(values), np.bool_)
    connect[breaks * 2 + 1] = False
    return Points(times.ravel(), values, connect, [Span(float(times[n, 1]), float(times[n + 1, 0])) for n in breaks])


class _Segment(NamedTuple):
    """A limit that stands, in seconds before the end of the span; `word` names a value of the past at its end,
    `is_current` the one at the right edge."""

    start_s: float
    end_s: float
    value: float
    word: str
    is_current: bool


class LimitLine:
    """The line of a limit, or of what was last known of it."""

    def __init__(self, limit: Limit, steps: StepFunction) -> None:
        self.limit, self._steps = limit, steps
        self.is_stale = steps is limit.stale
        self.pen = QPen()
        self.segments: list[_Segment] = []

    @property
    def value(self) -> float | None:
        """The present one."""
        return self._steps.value

    def ink(self) -> str:
        return current().muted if self.is_stale else current().tint(self.limit.meaning).ink

    def apply_theme(self) -> None:
        self.pen = pen(self.ink(), current().line_px, is_dashed=True)
        if self.is_stale or self.limit.is_draft:
            self.pen.setDashPattern(_STALE_DASHES if self.is_stale else _DRAFT_DASHES)

    def follow(self, span: Span, pixel_s: float) -> None:
        """Steps through the values of a time span."""
        limit, changes = self.limit, self._steps.between(*span)
        is_replaced = limit.stale is not None and (self.is_stale or limit.stale.value is not None)
        is_lost_at_edge = len(changes) > 1 and changes[-1].value is None and changes[-1].time_s > span.end_s - pixel_s
        if is_lost_at_edge and not is_replaced:
            changes.pop()  # it is still named, as at the end of a recording
        self.segments = []
        for number, change in enumerate(changes):
            if change.value is None:
                continue
            later = changes[number + 1 :]
            following = next((change.value for change in later if change.value is not None), None)
            # An equal value that follows is named at its own end.
            word = value_text(change.value, limit.decimals) if later and change.value != following else ""
            word = tr("stale") if self.is_stale else word
            start_s = max(change.time_s, span.start_s) - span.end_s
            end_s = later[0].time_s - span.end_s if later else 0.0
            self.segments.append(_Segment(start_s, end_s, change.value, word, not later))


class LaneView(QGraphicsItem):
    """Made once for a lane; `box` is the rectangle of its values in the scene."""

    def __init__(self, lane: Lane) -> None:
        super().__init__()
        self.lane = lane
        self.box, self._bounds = QRectF(), QRectF()
        self.used_scale = lane.scales[0]
        self.steady: object = None
        """What all but the curve depends on."""
        self._chosen: Scale | None = None
        """The vertical range that a person set."""
        self._least_scale = 0
        self._length_s = 1.0
        self.values = LabelAxis("left")
        self.limits = [LimitLine(limit, limit.steps) for limit in lane.limits]
        self.limits += [LimitLine(limit, limit.stale) for limit in lane.limits if limit.stale is not None]
        self.points = Points(np.empty(0), np.empty(0), "all", [])
        self._curve, self.pen, self._grid_pen = QPainterPath(), QPen(), QPen()
        self._lines: list[tuple[QPen, list[QLineF]]] = []

    def apply_theme(self, ink: str) -> None:
        """`ink`: of the curve."""
        theme = current()
        self.values.apply_theme(None)
        # Black hairlines would hide the curve.
        self._grid_pen = QPen(QColor(theme.divider if theme.border_px == 1 else "#9A9A9A"))
        self.ink, self.pen, self.line_px = ink, pg.mkPen(ink), theme.line_px + 1
        for line in self.limits:
            line.apply_theme()

    def place(self, box: QRectF | None) -> None:
        """Puts the lane at `box`, with the labels of its values at the left; None: hides it."""
        self.steady = None
        for item in (self, self.values):
            item.setVisible(box is not None)
        if box is not None:
            self.prepareGeometryChange()
            self.box, self._bounds = box, box.adjusted(0, -EDGE_PX, EDGE_PX, EDGE_PX)
            self.values.setWidth(box.left())
            self.values.setGeometry(QRectF(0, self._bounds.top(), box.left(), self._bounds.height()))

    def fit(self, *, is_chosen_too: bool = False) -> None:
        """Lets the next draw choose a smaller scale; otherwise the scale only grows."""
        self._least_scale = 0
        if is_chosen_too:
            self._chosen = None

    def zoom(self, factor: float) -> None:
        """Shows `factor` times as much of the values, around the middle of those in sight."""
        (low, high, _), whole = self.used_scale, self.lane.scales[-1]
        middle, half = (low + high) / 2, (high - low) / 2 * factor
        half = min(max(half, (whole.high - whole.low) / 1000), whole.high - whole.low)
        self._chosen = Scale(middle - half, middle + half, 0.0)

    def draw(self, span: Span, times: list[float]) -> None:
        """Draws curve and limits of a time span, grows the scale where it must, and lines at these times."""
        lane, box, self._length_s = self.lane, self.box, span.length_s
        envelope = lane.series.decimated(*span, min(_MAX_BUCKETS, max(50, int(box.width()))))
        seen = [float(envelope.low.min()), float(envelope.high.max())] if len(envelope.low) else []
        for line in self.limits:
            line.follow(span, span.length_s / max(1.0, box.width()))
            seen += [segment.value for segment in line.segments]
        seen = seen or list(lane.scales[0][:2])
        fitting = fitting_scale(lane.scales[self._least_scale :], min(seen), max(seen))
        self._least_scale = lane.scales.index(fitting)
        self.used_scale = self._chosen or fitting
        time_s, value, connect, gaps = self.points = points(envelope, origin_s=span.end_s, gap_s=lane.gap_s)
        newest = lane.series.last
        if newest is not None and newest.time_s < span.end_s - lane.gap_s:
            gaps.append(Span(newest.time_s - span.end_s, 0.0))
        self._curve = pg.arrayToQPath(self.x_of(time_s), self.y_of(value), connect, finiteCheck=False)
        steady = self.used_scale, span.length_s, times, gaps, [line.segments for line in self.limits]
        if steady != self.steady:
            self.steady = steady
            self._draw_lines(times)

    def _draw_lines(self, times: list[float]) -> None:
        box = self.box
        levels = [self.y_of(value) for value in self.values.show_scale(self.used_scale, box.height())]
        grid = [QLineF(box.left(), y, box.right(), y) for y in levels]
        grid += [QLineF(x, box.top(), x, box.bottom()) for x in map(self.x_of, times)]
        self._lines = [(self._grid_pen, grid)]
        for line in self.limits:
            ends = [(self.x_of(part.start_s), self.x_of(part.end_s), self.y_of(part.value)) for part in line.segments]
            self._lines.append((line.pen, [QLineF(left, y, right, y) for left, right, y in ends]))

    def boundingRect(self) -> QRectF:
        return self._bounds

    def paint(self, painter: QPainter, _option: QStyleOptionGraphicsItem, _widget: QWidget | None = None) -> None:
        painter.setClipRect(self._bounds)
        for line_pen, lines in self._lines:
            painter.setPen(line_pen)
            painter.drawLines(lines)
        if self._curve.isEmpty():  # in a drawing it would be a path that no reader accepts
            return
        ratio = painter.device().devicePixelRatioF()
        painter.setPen(self.pen)
        painter.drawPath(self._curve)
        # Lines of one pixel side by side are far cheaper than a wider pen. To the right, then down: diagonally, lines
        # that rise would have gaps and lines that fall would stay thin.
        for x, y in ((1, 0), (0, 1)) * (min(_MAX_PX, round(self.line_px * ratio)) - 1):
            painter.translate(x / ratio, y / ratio)
            painter.drawPath(self._curve)

    def x_of(self, time_s: Place) -> Place:
        """The place in the scene of a time after the end of the span, which is negative."""
        return time_s * (self.box.width() / self._length_s) + self.box.right()

    def y_of(self, value: Place) -> Place:
        """The place of a value in the scene."""
        low, high, _ = self.used_scale
        return (value - low) * (self.box.height() / (low - high)) + self.box.bottom()

    def level_of(self, value: float) -> float:
        """The same, within the lane."""
        return min(max(self.y_of(value), self.box.top()), self.box.bottom())

    # Words

    def name_limits(self, overlay: Overlay) -> None:
        """Names the current limits beside the lane, as near to their lines as there is room."""
        for line in self.limits:
            for part in (part for part in line.segments if part.is_current):
                text = tr(line.limit.label, value=value_text(part.value, line.limit.decimals))
                left, top = self.box.right() + 6, self.level_of(part.value) - overlay.line_px / 2
                ways = (sign * way for way in range(_FURTHEST_PX) for sign in (1, -1))
                overlay.put(text, line.ink(), (QPointF(left, top + way) for way in ways), is_bold=True)

    def name_past(self, overlay: Overlay) -> None:
        """Names past and stale limits at their ends and writes "no data" into gaps, where there is room."""
        box = self.box
        for line in self.limits:
            for part in (part for part in line.segments if part.word):
                size = overlay.size(part.word, is_bold=True)
                left, y = self.x_of(part.end_s) - 4 - size.width(), self.level_of(part.value)
                if left > self.x_of(part.start_s) + 4:
                    places = QPointF(left, y - size.height() - 1), QPointF(left, y + 1)
                    overlay.put(part.word, line.ink(), places, is_bold=True)
        for gap in self.points.gaps:
            left, right = max(box.left(), self.x_of(gap.start_s)), min(box.right(), self.x_of(gap.end_s))
            size = overlay.size(tr("no data"), is_on_ground=True)
            if right - left > size.width():
                tops = (box.top() + part * box.height() - size.height() / 2 for part in (0.5, 0.25, 0.75))
                middles = (QPointF((left + right - size.width()) / 2, top) for top in tops)
                overlay.put(tr("no data"), current().text, middles, ground=current().surface)
