"""One lane of a plot as items of pyqtgraph: curve, limits, axis, grid, and the words and lines that lie in front.

Times are drawn relative to the end of the span, so that the range of the view, its ticks and its grid stand still while
the curve moves below them.
"""

from collections.abc import Iterable
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QLineF, QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPen, QStaticText, QTransform
from PySide6.QtWidgets import QGraphicsItem, QGraphicsRectItem, QGraphicsScene, QStyleOptionGraphicsItem, QWidget

from app.samples.samples import Envelope, StepFunction
from app.text.i18n import tr
from ui.plots.axis import LabelAxis
from ui.plots.lanes import Lane, Limit, Span, fitting_scale, value_text
from ui.style import icons
from ui.style.icons import Icon
from ui.style.theme import Size, current, font
from ui.widgets.readout import pen

GAP_PX: Final = 4
"""Beside a word, between it and others."""
PAD_PX: Final = 6
_PAD_Y_PX: Final = 2
"""Around a word on a ground."""
ICON_PX: Final = 14
_ROUND_PX: Final = 4
_DOT_PX: Final = 4
_MAX_TEXTS: Final = 200
"""Kept laid out."""


class Shown(NamedTuple):
    """A word or an icon in its room; over curves a word has a ground."""

    what: str | Icon
    room: QRectF
    ink: QColor | str
    is_bold: bool
    ground: str


class Overlay(QGraphicsRectItem):
    """`clear`, then `put` words and icons, the most important first. Places are those of the scene, its rectangle is
    the whole of that."""

    def __init__(self) -> None:
        super().__init__()
        self.setZValue(10)
        self.shown: list[Shown] = []
        self.lines: list[tuple[float, QColor | str]] = []
        """Their places across, and their colours."""
        self.dots: list[tuple[QPointF, str]] = []
        self._box = QRectF()
        self._has_focus = False
        self.apply_theme()

    def apply_theme(self) -> None:
        self.fonts = font(Size.SMALL), font(Size.SMALL, is_bold=True)
        self.line_px = QFontMetricsF(self.fonts[True]).height()
        self._laid_out = lru_cache(_MAX_TEXTS)(self._lay_out)  # which takes longer than drawing it

    def clear(self, box: QRectF, *, has_focus: bool) -> None:
        """`box`: all lanes, through which lines go; it is framed if it `has_focus`."""
        self.update()
        self._box, self._has_focus = box, has_focus
        for part in (self.shown, self.lines, self.dots):
            part.clear()

    def size(self, what: str | Icon, *, is_bold: bool = False, is_on_ground: bool = False) -> QSizeF:
        if isinstance(what, Icon):
            return QSizeF(ICON_PX, ICON_PX)
        size = self._laid_out(what, is_bold).size()
        return size + QSizeF(2 * PAD_PX, _PAD_Y_PX * 2) if is_on_ground else size

    def _lay_out(self, text: str, is_bold: bool, /) -> QStaticText:
        laid_out = QStaticText(text)
        laid_out.setTextFormat(Qt.TextFormat.PlainText)
        laid_out.prepare(QTransform(), self.fonts[is_bold])
        return laid_out

    def put(
        self, what: str | Icon, ink: QColor | str, places: Iterable[QPointF], *, is_bold: bool = False,
        ground: str = "", is_above: bool = False,
    ) -> QRectF | None:  # fmt: skip
        """Shows a word or an icon at the first of `places`, its upper left corners, where it is apart from all others,
        or where it `is_above` them. Returns its room, None where there is none."""
        size = self.size(what, is_bold=is_bold, is_on_ground=bool(ground))
        for corner in places:
            room = QRectF(corner.toPoint(), size)
            around = room.adjusted(-GAP_PX, 0, GAP_PX, 0)
            if is_above or not any(around.intersects(other.room) for other in self.shown):
                self.shown.append(Shown(what, room, ink, is_bold, ground))
                return room
        return None

    def paint(self, painter: QPainter, _option: QStyleOptionGraphicsItem, _widget: QWidget | None = None) -> None:
        theme = current()
        if self._has_focus:
            painter.setPen(QPen(QColor(theme.information.ink), 2))
            painter.drawRect(self._box)
        for x, ink in self.lines:
            painter.setPen(QColor(ink))
            painter.drawLine(QLineF(x, self._box.top(), x, self._box.bottom()))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(QColor(theme.surface), 1.5))
        for place, ink in self.dots:
            painter.setBrush(QColor(ink))
            painter.drawEllipse(place, _DOT_PX, _DOT_PX)
        for what, room, ink, is_bold, ground in self.shown:
            if isinstance(what, Icon):
                icons.draw(painter, what, room, ink)
                continue
            if ground:
                painter.setPen(Qt.PenStyle.NoPen)
                painter.setBrush(QColor(ground))
                painter.drawRoundedRect(room, _ROUND_PX, _ROUND_PX)
            painter.setFont(self.fonts[is_bold])
            painter.setPen(QColor(ink))
            corner = room.topLeft() + QPointF(PAD_PX, _PAD_Y_PX) if ground else room.topLeft()
            painter.drawStaticText(corner, self._laid_out(what, is_bold))


def beside(x: float, y: float, size: QSizeF, within: QRectF) -> QPointF:
    """The corner of a word beside a point: at its right, or at its left where there is no room."""
    left = x + 8 if x + 8 + size.width() <= within.right() else max(0.0, x - 8 - size.width())
    top = min(max(y - size.height() / 2, within.top()), max(within.top(), within.bottom() - size.height()))
    return QPointF(left, top)


_MAX_BUCKETS: Final = 1000
# One and a half logical pixels at 200 %; more would take longer than a person notices.
_MAX_PX: Final = 3
EDGE_PX: Final = 2
"""Of the view around the box, so that lines on its edge are whole."""
_FURTHEST_PX: Final = 60
"""The label of a limit from its line."""
_CLOSING_S: Final = 0.1
"""Between what is lost as the port is closed and the end of a recording."""
_STALE_DASHES: Final = [1, 4]
"""Distinguishable from the module's own limits without colour."""


class Points(NamedTuple):
    """A curve: `connect` says which points are joined to the next, "all" without gaps."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    connect: NDArray[np.bool_] | str
    gaps: list[Span]


def points(envelope: Envelope, *, origin_s: float, gap_s: float) -> Points:
    """Joins the lowest and the highest value of each bucket, interrupted where samples are missing."""
    x = np.column_stack((envelope.start_s, envelope.end_s)).ravel() - origin_s
    y = np.column_stack((envelope.low, envelope.high)).ravel().astype(np.float64)
    breaks = np.flatnonzero(envelope.start_s[1:] - envelope.end_s[:-1] > gap_s)
    gaps = [Span(float(envelope.end_s[n]), float(envelope.start_s[n + 1])) for n in breaks]
    if not gaps:
        return Points(x, y, "all", gaps)
    connect = np.ones(len(x), np.bool_)
    connect[breaks * 2 + 1] = False
    return Points(x, y, connect, gaps)


class Curve(pg.PlotCurveItem):  # type: ignore[misc]
    """Lines somewhere in `bounds`, which is the view: to look for their own takes long."""

    line_px = 1
    """Lines of one pixel side by side, which are far cheaper than a wider pen."""

    def __init__(self) -> None:
        self.bounds = QRectF()
        super().__init__(antialias=False, skipFiniteCheck=True)

    def boundingRect(self) -> QRectF:
        return self.bounds

    def paint(self, painter: QPainter, _option: QStyleOptionGraphicsItem, _widget: QWidget | None = None) -> None:
        ratio, path = painter.device().devicePixelRatioF(), self.getPath()
        painter.setPen(self.opts["pen"])
        painter.drawPath(path)
        # To the right, then down: diagonally, lines that rise would have gaps and lines that fall would stay thin.
        for x, y in ((1, 0), (0, 1)) * (min(_MAX_PX, round(self.line_px * ratio)) - 1):
            painter.setWorldTransform(painter.worldTransform() * QTransform.fromTranslate(x / ratio, y / ratio))
            painter.drawPath(path)


class _Segment(NamedTuple):
    """A limit that stands, in seconds before the end of the span; `word` names a value of the past at its end,
    `is_current` the one at the right edge."""

    start_s: float
    end_s: float
    value: float
    word: str
    is_current: bool


class LimitLine(Curve):
    """The line of a limit, or of what was last known of it."""

    def __init__(self, limit: Limit, steps: StepFunction) -> None:
        super().__init__()
        self.limit, self._steps = limit, steps
        self.is_stale = steps is limit.stale
        self.segments: list[_Segment] = []

    @property
    def value(self) -> float | None:
        return self._steps.value

    @property
    def label(self) -> str:
        return (self.is_stale and self.limit.stale_label) or self.limit.label

    def ink(self) -> str:
        return current().muted if self.is_stale else current().tint(self.limit.meaning).ink

    def apply_theme(self, ratio: float) -> None:
        line = pen(self.ink(), current().line_px * ratio, is_dashed=True)
        if self.is_stale:
            line.setDashPattern(_STALE_DASHES)
        line.setCosmetic(True)
        self.setPen(line)

    def draw(self, span: Span) -> None:
        """Steps through the values of a time span."""
        limit, changes = self.limit, self._steps.between(*span)
        is_replaced = limit.stale is not None and (self.is_stale or limit.stale.value is not None)
        is_lost_at_edge = (
            len(changes) > 1 and changes[-1].value is None and changes[-1].time_s > span.end_s - _CLOSING_S
        )
        if is_lost_at_edge and not is_replaced:
            changes.pop()  # it is still named, as at the end of a recording
        segments = []
        for number, change in enumerate(changes):
            if change.value is None:
                continue
            later = changes[number + 1 :]
            following = next((change.value for change in later if change.value is not None), None)
            # An equal value that follows is named at its own end.
            word = value_text(change.value, limit.decimals) if later and change.value != following else ""
            word = tr(limit.stale_word) if self.is_stale else word
            start_s = max(change.time_s, span.start_s) - span.end_s
            end_s = later[0].time_s - span.end_s if later else 0.0
            segments.append(_Segment(start_s, end_s, change.value, word, not later))
        if segments != self.segments:
            self.segments = segments
            self.setVisible(bool(segments))  # it takes time even with nothing in it
            x = [time_s for part in segments for time_s in (part.start_s, part.end_s)]
            self.setData(np.array(x), np.repeat([part.value for part in segments], 2).astype(float), connect="pairs")


class LaneView:
    """Made once for a lane; `box` is the rectangle of its view in the scene."""

    def __init__(self, lane: Lane, scene: QGraphicsScene) -> None:
        self.lane = lane
        self.box = QRectF()
        self.scale = lane.scales[0]
        self.gaps: list[Span] = []
        self._least_scale = 0
        self._span = Span(-1.0, 0.0)
        self._range: object = None
        """What range and grid depend on."""
        self.view = pg.ViewBox(enableMouse=False, enableMenu=False)
        self.view.disableAutoRange()
        self.view.setFlag(QGraphicsItem.GraphicsItemFlag.ItemIsFocusable, False)
        self.values = LabelAxis("left", self.view)
        self.curve, self.grid = Curve(), Curve()  # the grid of an axis would be a picture as large as the lane
        self.limits = [LimitLine(limit, limit.steps) for limit in lane.limits]
        self.limits += [LimitLine(limit, limit.stale) for limit in lane.limits if limit.stale is not None]
        self._lines = (self.grid, *self.limits, self.curve)
        for line in self._lines:
            self.view.addItem(line, ignoreBounds=True)
        for item in (self.view, self.values):
            scene.addItem(item)

    def apply_theme(self, ink: str, ratio: float) -> None:
        """`ink`: of the curve; `ratio`: device pixels per logical pixel, since cosmetic pens are in the former."""
        theme = current()
        self.values.apply_theme(None)
        # Black hairlines would hide the curve.
        self.grid.setPen(theme.divider if theme.border_px == 1 else "#9A9A9A", width=ratio)
        self.ink = ink
        self.curve.setPen(ink)
        self.curve.line_px = theme.line_px + 1
        for line in self.limits:
            line.apply_theme(ratio)

    def place(self, box: QRectF) -> None:
        """Puts the lane at `box`, with the labels of its values at the left."""
        self.box, self._range = box, None
        whole = box.adjusted(0, -EDGE_PX, EDGE_PX, EDGE_PX)
        self.values.setWidth(box.left())
        self.values.setGeometry(QRectF(0, whole.top(), box.left(), whole.height()))
        self.view.setGeometry(whole)

    def fit(self) -> None:
        """Lets the next draw choose a smaller scale; otherwise the scale only grows."""
        self._least_scale = 0

    def draw(self, span: Span, times: list[float]) -> None:
        """Draws curve and limits of a time span, grows the scale where it must, and lines at these times."""
        lane, self._span = self.lane, span
        envelope = lane.series.decimated(*span, min(_MAX_BUCKETS, max(50, int(self.box.width()))))
        curve = points(envelope, origin_s=span.end_s, gap_s=lane.gap_s)
        self.curve.setData(curve.x, curve.y, connect=curve.connect)
        self.gaps, newest = curve.gaps, lane.series.last
        if newest is not None and newest.time_s < span.end_s - lane.gap_s:
            self.gaps.append(Span(newest.time_s, span.end_s))
        for line in self.limits:
            line.draw(span)
        seen = [segment.value for line in self.limits for segment in line.segments]
        if len(envelope.low):
            seen += [float(envelope.low.min()), float(envelope.high.max())]
        seen = seen or list(lane.scales[0][:2])
        self.scale = fitting_scale(lane.scales[self._least_scale :], min(seen), max(seen))
        self._least_scale = lane.scales.index(self.scale)
        if (self.scale, span.length_s, times) != self._range:
            self._range = self.scale, span.length_s, times
            self._draw_grid(times)

    def _draw_grid(self, times: list[float]) -> None:
        length_s, (low, high, step) = self._span.length_s, self.scale
        across = EDGE_PX * length_s / max(1.0, self.box.width())
        up = EDGE_PX * (high - low) / max(1.0, self.box.height())
        self.view.setRange(
            xRange=(-length_s, across), yRange=(low - up, high + up), padding=0.0, disableAutoRange=False
        )
        for line in self._lines:
            line.prepareGeometryChange()
            line.bounds = self.view.viewRect()
        self.values.setTickSpacing(levels=[(step, 0.0)] if step else None)
        values = self.values.tickValues(low, high, self.box.height())[0][1]
        lines = [place for value in values for place in ((-length_s, value), (0.0, value))]
        lines += [(time_s, end) for time_s in times for end in (low, high)]
        x, y = np.array(lines, np.float64).reshape(-1, 2).T
        self.grid.setData(x, y, connect="pairs")

    def x(self, time_s: float) -> float:
        """The place of a time in the scene."""
        return self.box.left() + (time_s - self._span.start_s) / self._span.length_s * self.box.width()

    def y(self, value: float) -> float:
        """The place of a value in the scene, clamped to the scale."""
        part = (value - self.scale.low) / (self.scale.high - self.scale.low)
        return self.box.bottom() - min(1.0, max(0.0, part)) * self.box.height()

    # Words

    def name_limits(self, overlay: Overlay) -> None:
        """Names the current limits beside the lane, as near to their lines as there is room."""
        for line in self.limits:
            for part in (part for part in line.segments if part.is_current):
                text = tr(line.label, value=value_text(part.value, line.limit.decimals))
                left, top = self.box.right() + 6, self.y(part.value) - overlay.line_px / 2
                ways = (sign * way for way in range(_FURTHEST_PX) for sign in (1, -1))
                overlay.put(text, line.ink(), (QPointF(left, top + way) for way in ways), is_bold=True)

    def name_past(self, overlay: Overlay) -> None:
        """Names past and stale limits at their ends and writes "no data" into gaps, where there is room."""
        end_s, box = self._span.end_s, self.box
        for line in self.limits:
            for part in (part for part in line.segments if part.word):
                size = overlay.size(part.word, is_bold=True)
                left, y = self.x(part.end_s + end_s) - 4 - size.width(), self.y(part.value)
                if left > self.x(part.start_s + end_s) + 4:
                    places = QPointF(left, y - size.height() - 1), QPointF(left, y + 1)
                    overlay.put(part.word, line.ink(), places, is_bold=True)
        for gap in self.gaps:
            left, right = max(box.left(), self.x(gap.start_s)), min(box.right(), self.x(gap.end_s))
            size = overlay.size(tr("no data"), is_on_ground=True)
            if right - left > size.width():
                tops = (box.top() + part * box.height() - size.height() / 2 for part in (0.5, 0.25, 0.75))
                middles = (QPointF((left + right - size.width()) / 2, top) for top in tops)
                overlay.put(tr("no data"), current().text, middles, ground=current().surface)
