"""The axes of the time plots: labels of pyqtgraph, kept as pictures, which makes a redraw six times as fast."""

import math
import time
from collections.abc import Iterable
from typing import Final

import pyqtgraph as pg
from PySide6.QtGui import QColor, QFontMetricsF, QPen
from PySide6.QtWidgets import QGraphicsItem

from app.text.i18n import tr
from ui.plots.lanes import Tick
from ui.style.theme import Size, current, font

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
    """An axis of labels only."""

    def __init__(self, side: str, view: pg.ViewBox, *, is_cached: bool = True) -> None:
        super().__init__(side, linkView=view)
        self.enableAutoSIPrefix(False)
        self.setStyle(tickLength=0, tickAlpha=0, hideOverlappingLabels=_MARGIN_PX, autoExpandTextSpace=False)
        if is_cached:
            self.setCacheMode(QGraphicsItem.CacheMode.DeviceCoordinateCache)

    def show_labels(self, labels: list[Tick]) -> None:
        """Making the picture of an axis takes as long as a redraw of all lanes."""
        if [labels] != self._tickLevels:
            self.setTicks([labels])

    def apply_theme(self, line: QPen | None) -> None:
        self.setTickFont(font(Size.SMALL))
        self.setTextPen(QColor(current().muted))
        self.setPen(line)


def times(length_s: float, most: int, end_wall_s: float | None = None) -> list[Tick]:
    """At most as many ticks, counted back from the end of a span; with that end in seconds since 1970, at round times
    of day."""
    step_s = next((step for step in _STEPS_S if length_s / step <= most), _STEPS_S[-1])
    decimals = max(0, math.ceil(-math.log10(step_s) - 1e-9)) if step_s < 1 else 0
    end_s = end_wall_s or 0.0
    numbers = range(math.ceil((end_s - length_s) / step_s - 1e-6), math.floor(end_s / step_s + 1e-6) + 1)
    if end_wall_s is None:
        return [(n * step_s, _ago(-n * step_s, step_s, decimals)) for n in numbers]
    return [(n * step_s - end_s, clock_text(n * step_s, decimals)) for n in numbers]


def fitting_times(
    ticks: Iterable[Tick], length_s: float, second_px: float, taken: Iterable[tuple[float, float]]
) -> list[Tick]:
    """The ticks whose labels have room; that at the very beginning is moved for it. `taken` as below."""
    metrics, begin_s = QFontMetricsF(font(Size.SMALL)), -length_s
    moved = []
    for time_s, label in ticks:
        half_s = (metrics.horizontalAdvance(label) + _GAP_PX) / 2 / second_px
        moved.append((begin_s + half_s if time_s < begin_s + 1 / second_px else time_s, label))
    return apart_from_each_other(moved, second_px, [(-math.inf, begin_s * second_px - 0.5), *taken])


def apart_from_each_other(
    labels: Iterable[Tick], unit_px: float, taken: Iterable[tuple[float, float]] = ()
) -> list[Tick]:
    """Those of `labels`, the most important first, that touch none before them and no place that is `taken`, in pixels
    from the zero of the axis; `unit_px` is its scale."""
    metrics, rooms, shown = QFontMetricsF(font(Size.SMALL)), list(taken), list[Tick]()
    for place, label in labels:
        half = (metrics.horizontalAdvance(label) + _GAP_PX) / 2
        left, right = place * unit_px - half, place * unit_px + half
        if all(right <= other_left or other_right <= left for other_left, other_right in rooms):
            rooms.append((left, right))
            shown.append((place, label))
    return shown


def clock_text(wall_s: float, decimals: int = 0) -> str:
    """The local time of day of a number of seconds since 1970, with `decimals` of a second."""
    whole = math.floor(round(wall_s, decimals))
    text = time.strftime("%H:%M:%S", time.localtime(whole))
    if not decimals:
        return text
    part = round((wall_s - whole) * 10**decimals)
    return f"{text}.{max(0, part):0{decimals}d}"


def ago_text(seconds: float, decimals: int = 1) -> str:
    """A time before now, such as "−5.0 s"."""
    return tr("−{seconds} s", seconds=f"{seconds:.{decimals}f}")


def _ago(seconds: float, step_s: float, decimals: int) -> str:
    if seconds < step_s / 2:
        return tr("now")
    if step_s >= 60:
        return tr("−{minutes} min", minutes=f"{seconds / 60:g}")
    return ago_text(seconds, decimals)
