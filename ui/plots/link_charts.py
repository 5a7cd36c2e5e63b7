"""Charts of link statistics: round trips, and all over time."""

from collections.abc import Sequence
from typing import ClassVar, Final, NamedTuple

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QSize
from PySide6.QtGui import QColor

from app.diagnosis.link_statistics import Slice, TripClass
from app.text.durations import duration
from app.text.i18n import tr
from ui.plots.static_plot import StaticPlot
from ui.style.theme import Meaning, Theme, current, scaled

_TICK_MS: Final = frozenset((1, 4, 16, 64, 250, 1000))
"""Bounds labelled below the histogram; there is no room for all."""
_LEAST: Final = 0.03
"""Height of the lowest bar as a part of the highest."""
_HEAD: Final = 1.3
"""Height of the histogram as a multiple of its highest bar, for the share above that."""
_SHARE_PX: Final = 40
_MIN_PX: Final = 1.5


def percent_text(share: float) -> str:
    """ "0 %", "0.03 %", "12 %"."""
    percent = share * 100
    return f"{percent:.0f} %" if percent >= 10 or not percent else f"{percent:.2g} %"


def _bars(colour: QColor, **places: object) -> pg.BarGraphItem:
    return pg.BarGraphItem(brush=colour, pen=None, **places)


class Histogram(StaticPlot):
    """Histogram of round trips, with shares."""

    def __init__(self) -> None:
        super().__init__("figures_trips")
        self._classes: tuple[TripClass, ...] = ()

    def show_classes(self, classes: tuple[TripClass, ...]) -> None:
        if classes == self._classes:
            return
        self._classes = classes
        total = sum(trips.count for trips in classes)
        parts = "; ".join(f"{_bound(trips)}: {trips.count}" for trips in classes if trips.count)
        self.announce(tr("Round trips: {n}. {classes}", n=total, classes=parts), name=tr("Round trips"))
        self.redraw()

    def draw(self, theme: Theme) -> None:
        counts = np.array([trips.count for trips in self._classes])
        total = counts.sum()
        if not total:
            self.show_nothing(tr("not measured yet"))
            return
        most, middles = counts.max(), np.arange(len(counts)) + 0.5
        heights = np.where(counts, np.maximum(counts, most * _LEAST), 0)
        self.add(_bars(QColor(theme.curves[0]), x=middles, height=heights, width=0.9))
        self.set_range((0.0, len(counts)), (0.0, most * _HEAD))
        # A share that is wider than its bar must not reach into a higher one, or another share.
        reach = scaled(_SHARE_PX) * len(counts) // max(1, self.width())
        for n in np.flatnonzero(counts * 20 >= total).tolist():
            first = max(0, n - reach)
            if first + counts[first : n + reach + 1].argmax() == n:
                self.add_text(percent_text(counts[n] / total), theme.text, (middles[n], heights[n]), (0.5, 1.0))
        bounds = enumerate((trips.up_to_ms for trips in self._classes), 1)
        self.show_ticks("bottom", [(n, f"{ms:g}") for n, ms in bounds if ms in _TICK_MS])


def _bound(trips: TripClass) -> str:
    return tr("longer") if trips.up_to_ms is None else tr("up to {ms} ms", ms=f"{trips.up_to_ms:g}")


class Stretch(NamedTuple):
    """The time line from `now_s - length_s` to `now_s`."""

    now_s: float
    length_s: float
    slices: tuple[Slice, ...]
    is_recorded: bool = False
    """It ends with a file."""


class _Band(NamedTuple):
    title: str
    text: str
    """Shown for the highest value."""
    values: Sequence[float]
    ink: QColor


class OverTime(StaticPlot):
    """Slowest answer, queries without reply and invalid bytes over time, with marks for restarts of the module and lost
    ports."""

    usual: ClassVar = QSize(640, 200)
    least: ClassVar = QSize(260, 150)

    def __init__(self) -> None:
        super().__init__("figures_over_time")
        self._stretch = Stretch(0.0, 600.0, ())

    def show_stretch(self, stretch: Stretch) -> None:
        self._stretch = stretch
        self.announce(
            tr(
                "Over the last {time}: {lanes}; restarts: {restarts}; port lost: {losses}",
                time=duration(stretch.length_s),
                lanes="; ".join(f"{band.title} {band.text}" for band in reversed(self._bands())),
                restarts=sum(part.counters.restarts for part in stretch.slices),
                losses=sum(part.losses for part in stretch.slices),
            )
        )
        self.redraw()

    def _bands(self) -> tuple[_Band, ...]:
        """From below upwards."""
        theme, slices = current(), self._stretch.slices
        slowest, missed = [part.slowest_s or 0.0 for part in slices], [part.counters.time_outs for part in slices]
        rejected, ink = [part.counters.rejected for part in slices], theme.ink(Meaning.ATTENTION)
        worst = f"{max(slowest) * 1000:.1f} ms" if any(slowest) else "–"
        return (
            _Band(tr("Invalid bytes"), f"{sum(rejected):,}", rejected, ink),
            _Band(tr("Without reply"), f"{sum(missed):,}", missed, ink),
            _Band(tr("Slowest answer"), worst, slowest, QColor(theme.curves[0])),
        )

    def draw(self, theme: Theme) -> None:
        stretch, bands = self._stretch, self._bands()
        begins = np.array([part.begins_s for part in stretch.slices]) - stretch.now_s
        widths = np.full(len(begins), max(1.0, _MIN_PX * stretch.length_s / max(1, self.width())))
        for number, band in enumerate(bands):
            self.add(pg.InfiniteLine(number, angle=0, pen=pg.mkPen(theme.divider, width=theme.border_px)))
            values = np.array(band.values, np.float64)
            if values.any():
                heights = np.where(values, np.maximum(values / values.max(), _LEAST), 0) * 0.8
                self.add(_bars(band.ink, x0=begins, y0=number, width=widths, height=heights))
        for place, part in zip(begins + 0.5, stretch.slices, strict=True):
            if part.counters.restarts or part.losses:
                ink = theme.ink(Meaning.DANGER if part.losses else Meaning.INFORMATION)
                symbol = "s" if part.losses else "t"  # a square, or a triangle that points down
                mark = pg.ScatterPlotItem([place], [len(bands)], symbol=symbol, size=scaled(8), brush=ink, pen=None)
                self.add(pg.InfiniteLine(place, pen=pg.mkPen(ink, width=theme.line_px, dash=(4, 3))), mark)
        self.set_range((-stretch.length_s, 0.0), (0.0, len(bands) + 0.1))
        self.show_ticks("left", [(n + 0.4, f"{band.title}\n{band.text}") for n, band in enumerate(bands)])
        length = duration(stretch.length_s)
        begin, end = (f"−{length}", tr("end")) if stretch.is_recorded else (tr("{time} ago", time=length), tr("now"))
        self.show_ticks("bottom", [(-stretch.length_s, begin), (0.0, end)])
