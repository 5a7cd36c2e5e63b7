"""Axes of labels that never touch each other, and charts that show something and are not operated."""

import math
from collections.abc import Sequence
from typing import Any, ClassVar, Final

import pyqtgraph as pg
from PySide6.QtCore import QEvent, QRectF, QSize, Qt
from PySide6.QtGui import QAccessible, QColor, QFontMetricsF, QPainter, QPen
from PySide6.QtWidgets import QGraphicsItem, QSizePolicy

from app.system.clock import clock_text
from app.text.i18n import tr
from ui.style.theme import Size, Space, Theme, current, font, scaled
from ui.widgets.controls import in_column
from ui.widgets.readout import PaintedWidget
from ui.widgets.visibility_timer import VisibilityTimer

# Distances between ticks, in seconds.
_STEPS_S: Final = (
    *(0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5),
    *(1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0, 7200.0),
    *(14400.0, 21600.0, 43200.0),
)
# Labels may be as far beyond the ends of an axis.
_MARGIN_PX: Final = 60
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
        shown = length_s, end_wall_s, self.width()
        if shown != self._shown:
            self._shown, self._end_wall_s, self.picture = shown, end_wall_s, None
            self._times = self.tickValues(-length_s, 0.0, self.width())[0][1]
            self.update()
        return self._times

    def tickSpacing(self, begin_s: float, end_s: float, _size: float) -> list[tuple[float, float]]:
        """As many as there is room for, at round times."""
        most = max(2, int(self.width() / QFontMetricsF(font(Size.SMALL)).horizontalAdvance("00:00:00.000")))
        length_s = end_s - begin_s
        # Whole days where a clock that was set on the way makes a log of decades.
        days_s = math.ceil(length_s / most / 86400) * 86400.0
        step_s = next((step for step in _STEPS_S if int(length_s / step) <= most), days_s)
        return [(step_s, -(self._end_wall_s or 0.0) % step_s)]

    def tickStrings(self, values: list[float], _scale: float, step_s: float) -> list[str]:
        decimals = max(0, math.ceil(-math.log10(step_s) - 1e-9)) if step_s < 1 else 0
        if self._end_wall_s is not None:
            return [clock_text(self._end_wall_s + value, decimals) for value in values]
        labels = []
        for value in values:
            if -value < step_s / 2:
                labels.append(tr("now"))
            elif step_s >= 60:
                labels.append("−" + tr("{value:.0f} min", value=-value / 60))
            else:
                labels.append(ago_text(-value, decimals))
        return labels


def ago_text(seconds: float, decimals: int) -> str:
    """A time before now, such as "−5.0 s"."""
    return "−" + tr("{value} s", value=f"{seconds:.{decimals}f}")


class StaticPlot(PaintedWidget):
    """A plot with axes in one view of pyqtgraph. `draw` puts the items into it, after each change and in each theme."""

    accessible_role: ClassVar = QAccessible.Role.Chart
    usual: ClassVar = QSize(320, 130)
    least: ClassVar = QSize(220, 90)

    def __init__(self, name: str) -> None:
        super().__init__()
        self.setObjectName(name)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.view: Any = None
        self.column = in_column(of=self, spacing=Space.XS, margins=0)
        VisibilityTimer(self, self.redraw, restyle=self.redraw)

    def _make(self) -> None:
        """When it is shown for the first time, since it takes 10 ms."""
        canvas = pg.GraphicsLayoutWidget()
        self.view = view = pg.ViewBox(enableMouse=False, enableMenu=False, defaultPadding=0.0)
        canvas.setObjectName(f"{self.objectName()}_canvas")
        canvas.viewport().setObjectName(f"{self.objectName()}_viewport")
        # The ground is the page's, which changes with the theme.
        canvas.viewport().setAutoFillBackground(False)
        canvas.setBackground(None)
        canvas.setCacheMode(pg.GraphicsView.CacheModeFlag.CacheNone)
        # The mouse is the widget's, and the page's that scrolls.
        canvas.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        canvas.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        # Half a label may be above the view, and half the last one beside it.
        canvas.ci.layout.setSpacing(0)
        canvas.ci.layout.setContentsMargins(0, scaled(Space.S), scaled(Space.M), 0)
        view.disableAutoRange()
        canvas.addItem(view, 0, 1)
        # Their width follows the labels: a picture of another width would cut them off.
        self.axes = {side: LabelAxis(side, view) for side in ("left", "bottom")}
        for axis in self.axes.values():
            axis.setCacheMode(axis.CacheMode.NoCache)
        canvas.addItem(self.axes["left"], 0, 0)
        canvas.addItem(self.axes["bottom"], 1, 1)
        self.column.insertWidget(0, canvas, 1)

    def redraw(self) -> None:
        """Draws all again, in the theme in use; a hidden chart is drawn when it is shown."""
        if not self.isVisible():
            return
        if self.view is None:
            self._make()
        theme = current()
        self.view.clear()
        for side, axis in self.axes.items():
            axis.apply_theme(pg.mkPen(theme.divider, width=theme.border_px) if side == "bottom" else None)
            self.show_ticks(side, ())
        self.draw(theme)

    def draw(self, theme: Theme) -> None:
        raise NotImplementedError

    def add(self, *items: Any) -> None:
        for item in items:
            self.view.addItem(item)

    def show_nothing(self, word: str) -> None:
        self.set_range((0.0, 1.0), (0.0, 1.0))
        item = pg.TextItem(word, QColor(current().muted), anchor=(0.5, 0.5))
        item.setFont(font(Size.SMALL))
        item.setPos(0.5, 0.5)
        self.add(item)

    def set_range(self, across: tuple[float, float], up: tuple[float, float]) -> None:
        self.view.setRange(xRange=across, yRange=up, padding=0.0, disableAutoRange=False)

    def show_ticks(self, side: str, labels: Sequence[tuple[float, str]], title: str = "") -> None:
        """Labels an axis, which takes the room that they need."""
        axis, metrics = self.axes[side], QFontMetricsF(font(Size.SMALL))
        title_px = metrics.height() + _GAP_PX if title else 0
        if title:
            axis.setLabel(title, **{"color": current().muted, "font-size": f"{scaled(Size.SMALL)}px"})
        if side == "left":
            widest_px = max((metrics.horizontalAdvance(label) for _, label in labels), default=0)
            axis.setWidth(widest_px + 2 * _GAP_PX + title_px)
        else:
            axis.setHeight((metrics.height() + _GAP_PX if labels else 2) + title_px)
        axis.setTicks([list(labels)])

    def sizeHint(self) -> QSize:
        """As high as the labels need in the size of text in use."""
        return QSize(self.usual.width(), scaled(self.usual.height()))

    def minimumSizeHint(self) -> QSize:
        return QSize(self.least.width(), scaled(self.least.height()))

    def resizeEvent(self, _event: QEvent) -> None:
        self.redraw()
