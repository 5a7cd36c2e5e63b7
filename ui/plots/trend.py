"""Small trend chart of one measured value over all checks."""

from collections.abc import Sequence
from typing import ClassVar, Final

import pyqtgraph as pg
from PySide6.QtCore import QSize
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QLabel, QSizePolicy

from app.records.check_store import Point
from app.text.i18n import tr
from ui.plots.static_plot import StaticPlot
from ui.style.theme import Theme, scaled
from ui.widgets.layouts import in_row
from ui.widgets.naming import named

_DOT_PX: Final = 7
_MAX_POINTS: Final = 200
"""Only the last ones: more could not be distinguished."""


class Trend(StaticPlot):
    """Equal distances between the checks, since days or minutes may lie between them."""

    usual: ClassVar = QSize(240, 96)
    least: ClassVar = QSize(160, 88)
    head_rows: ClassVar = 1

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._unit, self._decimals = "", 0
        self.points: tuple[Point, ...] = ()
        self._title, self._last = named(QLabel(), f"{name}_title", "small"), named(QLabel(), f"{name}_last", "small")
        self.column.addLayout(in_row(self._title, 1, self._last))
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def show_points(self, title: str, unit: str, points: Sequence[Point], *, decimals: int) -> None:
        """`points` from the oldest to the newest."""
        self._unit, self._decimals = unit, decimals
        self.points = tuple(points[-_MAX_POINTS:])
        values = [point.value for point in self.points]
        self._title.setText(title)
        self._last.setText(self._shown(values[-1]) if values else "")
        if values:
            text = tr(
                "{title}: {low} to {high}, last {last}; checks: {count}",
                title=title,
                count=len(values),
                low=self._shown(min(values)),
                high=self._shown(max(values)),
                last=self._last.text(),
            )
        else:
            text = tr("{setting}: {what}", setting=title, what=tr("not measured yet"))
        self.setToolTip(text)
        self.announce(text)
        self.redraw()

    def _shown(self, value: float) -> str:
        gap = "" if self._unit in ("°", "") else " "
        return f"{value:.{self._decimals}f}{gap}{self._unit}"

    def draw(self, theme: Theme) -> None:
        values = [point.value for point in self.points]
        if not values:
            self.show_nothing(tr("not measured yet"))
            return
        low, high, colour = min(values), max(values), QColor(theme.curves[0])
        edge = (high - low) / 5 or 1.0  # room for the symbols
        self.set_range((-0.2, len(values) - 0.8), (low - edge, high + edge))
        line = pg.mkPen(colour, width=theme.line_px + 0.5)
        self.add(pg.PlotDataItem(values, pen=line, symbol="o", symbolSize=scaled(_DOT_PX), symbolBrush=colour,
                                 symbolPen=None, antialias=True))  # fmt: skip
        self.show_ticks("left", [(value, self._shown(value)) for value in sorted({low, high})])
