"""One lane on the canvas: its view, axis, grid, curve and limits, as items of pyqtgraph; and what lies in front of all
lanes: words and icons, none of which covers another, lines and dots.

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

from app.samples.samples import SeriesSample
from app.text.i18n import tr
from ui.plots.charts import LabelAxis
from ui.plots.lanes import Lane, Limit, Span, value_text
from ui.style import icons
from ui.style.icons import Icon
from ui.style.theme import Size, current, font
from ui.widgets.readout import pen

_MAX_BUCKETS: Final = 1000
# One and a half logical pixels at 200 %; more would take longer than a person notices.
_MAX_PX: Final = 3
# Of the view around the box, so that lines on its edge are whole.
EDGE_PX: Final = 2
# A recording ends this much after what is lost as its port is closed.
_CLOSING_S: Final = 0.1
# Distinguishable from the module's own limits without colour.
_STALE_DASHES: Final = [1, 4]
# Beside a word, between it and others; and around a word on a ground.
GAP_PX: Final = 4
_PAD_PX: Final = QPointF(6, 2)
ICON_PX: Final = 14
_MAX_TEXTS: Final = 200


class Curve(pg.PlotCurveItem):  # type: ignore[misc]
    """Lines somewhere in `bounds`, which is the view: to look for their own takes long."""

    def __init__(self) -> None:
        self.bounds = QRectF()
        self.line_px = 1
        super().__init__(antialias=False, skipFiniteCheck=True)

    def boundingRect(self) -> QRectF:
        return self.bounds

    def paint(self, painter: QPainter, _option: QStyleOptionGraphicsItem, _widget: QWidget | None = None) -> None:
        """Draws lines of one pixel side by side, which are far cheaper than a wider pen."""
        ratio, path = painter.device().devicePixelRatioF(), self.getPath()
        painter.setPen(self.opts["pen"])
        painter.drawPath(path)
        # To the right, then down: diagonally, lines that rise would have gaps and lines that fall would stay thin.
        for x, y in ((1, 0), (0, 1)) * (min(_MAX_PX, round(self.line_px * ratio)) - 1):
            painter.setWorldTransform(painter.worldTransform() * QTransform.fromTranslate(x / ratio, y / ratio))
            painter.drawPath(path)


class LimitLine(Curve):
    """Steps through the values of a limit; `value` is the one at the right edge."""

    def __init__(self, limit: Limit) -> None:
        super().__init__()
        self.limit = limit
        self.value: float | None = None
        # Begin and end, in seconds before the end of the span, and value.
        self.parts: list[tuple[float, float, float]] = []

    def ink(self) -> str:
        return current().muted if self.limit.is_stale else current().tint(self.limit.meaning).ink

    def apply_theme(self, ratio: float) -> None:
        line = pen(self.ink(), current().line_px * ratio, is_dashed=True)
        if self.limit.is_stale:
            line.setDashPattern(_STALE_DASHES)
        line.setCosmetic(True)
        self.setPen(line)

    def draw(self, span: Span) -> None:
        changes = self.limit.steps.between(*span)
        if len(changes) > 1 and changes[-1].value is None and changes[-1].time_s > span.end_s - _CLOSING_S:
            changes.pop()  # else the limits of a recording would have no labels
        self.value = changes[-1].value if changes else None
        ends_s = [*(change.time_s for change in changes[1:]), span.end_s]
        parts = [
            (max(change.time_s, span.start_s) - span.end_s, end_s - span.end_s, change.value)
            for change, end_s in zip(changes, ends_s, strict=False)
            if change.value is not None
        ]
        if parts != self.parts:
            self.parts = parts
            self.setVisible(bool(parts))  # it takes time even with nothing in it
            x = [time_s for start_s, end_s, _value in parts for time_s in (start_s, end_s)]
            self.setData(np.array(x), np.repeat([part[2] for part in parts], 2).astype(float), connect="pairs")


class LaneView:
    """The view of a lane, made once for it; `box` is its rectangle in the scene."""

    def __init__(self, lane: Lane, scene: QGraphicsScene) -> None:
        self.lane = lane
        self.box = QRectF()
        self.scale = lane.scales[0]
        self.gaps: list[Span] = []
        self.ink = ""
        self._span = Span(-1.0, 0.0)
        # What range and grid depend on.
        self._range: object = None
        self.view = pg.ViewBox(enableMouse=False, enableMenu=False)
        self.view.disableAutoRange()
        self.view.setFlag(QGraphicsItem.GraphicsItemFlag.ItemIsFocusable, False)
        self.values = LabelAxis("left", self.view)
        self.curve, self.grid = Curve(), Curve()  # the grid of an axis would be a picture as large as the lane
        self.limits = [LimitLine(limit) for limit in lane.limits]
        self._lines = (self.grid, *self.limits, self.curve)
        for line in self._lines:
            self.view.addItem(line, ignoreBounds=True)
        scene.addItem(self.view)
        scene.addItem(self.values)

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

    def draw(self, span: Span, times: list[float]) -> None:
        """Draws curve and limits of a time span in the scale that has room for them, and lines at these times."""
        lane, self._span = self.lane, span
        envelope = lane.series.decimated(*span, min(_MAX_BUCKETS, max(50, int(self.box.width()))))
        # The lowest and the highest value of each bucket are joined, interrupted where samples are missing.
        x = np.column_stack((envelope.start_s, envelope.end_s)).ravel() - span.end_s
        y = np.column_stack((envelope.low, envelope.high)).ravel().astype(np.float64)
        breaks = np.flatnonzero(envelope.start_s[1:] - envelope.end_s[:-1] > lane.gap_s)
        self.gaps = [Span(float(envelope.end_s[n]), float(envelope.start_s[n + 1])) for n in breaks]
        connect: NDArray[np.bool_] | str = "all"
        if self.gaps:
            connect = np.ones(len(x), np.bool_)
            connect[breaks * 2 + 1] = False
        self.curve.setData(x, y, connect=connect)
        newest = lane.series.last
        if newest is not None and newest.time_s < span.end_s - lane.gap_s:
            self.gaps.append(Span(newest.time_s, span.end_s))
        for line in self.limits:
            line.draw(span)
        seen = [value for line in self.limits for _start_s, _end_s, value in line.parts]
        if len(y):
            seen += [float(y.min()), float(y.max())]
        low, high = (min(seen), max(seen)) if seen else lane.scales[0][:2]
        fitting = (scale for scale in lane.scales if scale.low <= low and high <= scale.high)
        self.scale = next(fitting, lane.scales[-1])
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
        return self.box.left() + (time_s - self._span.start_s) / self._span.length_s * self.box.width()

    def y(self, value: float) -> float:
        """The place of a value in the scene, clamped to the scale."""
        part = (value - self.scale.low) / (self.scale.high - self.scale.low)
        return self.box.bottom() - min(1.0, max(0.0, part)) * self.box.height()

    def reading(self, at_s: float) -> tuple[str, SeriesSample | None]:
        """The value at a time with its unit, or "no data" where no curve is drawn; and the sample."""
        lane = self.lane
        near = lane.series.around(at_s, within_s=lane.gap_s / 2)
        if near is None:
            return tr("no data"), None
        gap = "" if lane.unit == "°" else " "
        text = f"{value_text(near.value, lane.decimals)}{gap}{lane.unit}"
        outside = None if lane.outside is None else lane.outside(near.value, at_s)
        return text if outside is None else outside.beside(text), near


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
        # Lines through all lanes: their places across, and their colours.
        self.lines: list[tuple[float, QColor | str]] = []
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
        return size + QSizeF(2 * _PAD_PX.x(), 2 * _PAD_PX.y()) if is_on_ground else size

    def _lay_out(self, text: str, is_bold: bool, /) -> QStaticText:
        laid_out = QStaticText(text)
        laid_out.setTextFormat(Qt.TextFormat.PlainText)
        laid_out.prepare(QTransform(), self.fonts[is_bold])
        return laid_out

    def put(
        self,
        what: str | Icon,
        ink: QColor | str,
        places: Iterable[QPointF],
        *,
        is_bold: bool = False,
        ground: str = "",
        is_above: bool = False,
    ) -> QRectF | None:
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
            painter.drawEllipse(place, 4, 4)
        for what, room, ink, is_bold, ground in self.shown:
            if isinstance(what, Icon):
                icons.draw(painter, what, room, ink)
                continue
            if ground:
                painter.setPen(Qt.PenStyle.NoPen)
                painter.setBrush(QColor(ground))
                painter.drawRoundedRect(room, 4, 4)
            painter.setFont(self.fonts[is_bold])
            painter.setPen(QColor(ink))
            painter.drawStaticText(room.topLeft() + (_PAD_PX if ground else QPointF()), self._laid_out(what, is_bold))
