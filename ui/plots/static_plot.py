"""Base of the charts that show something and are not operated like a time plot."""

from collections.abc import Sequence
from typing import Any, ClassVar, Final

import pyqtgraph as pg
from PySide6.QtCore import QEvent, QSize, Qt
from PySide6.QtGui import QAccessible, QColor, QFontMetricsF
from PySide6.QtWidgets import QSizePolicy

from ui.plots.axis import LabelAxis
from ui.style.theme import Size, Space, Theme, current, font, scaled
from ui.widgets.controls import in_column
from ui.widgets.readout import PaintedWidget
from ui.widgets.visibility_timer import VisibilityTimer

_GAP_PX: Final = 4


class StaticPlot(PaintedWidget):
    """One view of pyqtgraph with axes. `draw` puts the items into it, after each change and in each theme."""

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
        canvas.viewport().setAutoFillBackground(False)
        canvas.setBackground(None)
        canvas.setCacheMode(
            pg.GraphicsView.CacheModeFlag.CacheNone
        )  # the ground is the page's, which changes with the theme
        canvas.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        # The mouse is the widget's, and the page's that scrolls.
        canvas.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.layout_of_view = canvas.ci.layout
        self.layout_of_view.setSpacing(0)
        view.disableAutoRange()
        view.sigResized.connect(self.fit_to_view)
        canvas.addItem(view, 0, 1)
        # Their width follows the labels: a picture of another width would cut them off.
        self.axes = {side: LabelAxis(side, view) for side in ("left", "bottom")}
        for axis in self.axes.values():
            axis.setCacheMode(axis.CacheMode.NoCache)
        canvas.addItem(self.axes["left"], 0, 0)
        canvas.addItem(self.axes["bottom"], 1, 1)
        self.column.insertWidget(0, canvas, 1)

    def redraw(self) -> None:
        """Draws all again, in the theme and language in use; a hidden chart is drawn when it is shown."""
        if not self.isVisible():
            return
        if self.view is None:
            self._make()
        theme = current()
        self.view.clear()
        # Half a label may be above the view, and half the last one beside it.
        self.layout_of_view.setContentsMargins(0, scaled(Space.S), scaled(Space.M), 0)
        for side, axis in self.axes.items():
            axis.apply_theme(pg.mkPen(theme.divider, width=theme.border_px) if side == "bottom" else None)
            self.show_ticks(side, ())
        self.draw(theme)

    def draw(self, theme: Theme) -> None:
        raise NotImplementedError

    def fit_to_view(self) -> None:
        """Called after a change of the view's size, for what is drawn in pixels."""

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
        lines = [line for _, label in labels for line in label.split("\n")]
        title_px = metrics.height() + _GAP_PX if title else 0
        if title:
            axis.setLabel(title, **{"color": current().muted, "font-size": f"{scaled(Size.SMALL)}px"})
        if side == "left":
            axis.setWidth(max((metrics.horizontalAdvance(line) for line in lines), default=0) + 2 * _GAP_PX + title_px)
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
