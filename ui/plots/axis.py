"""The axes of the time plots: labels of pyqtgraph, kept as pictures, which makes a redraw six times as fast."""

import math
import time
from typing import Final

import pyqtgraph as pg
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QGraphicsItem

from app.text.i18n import tr
from ui.plots.lanes import Tick
from ui.style.theme import Size, font

# Distances between ticks, in seconds.
_STEPS_S: Final = (
    *(0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5),
    *(1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0, 7200.0),
    *(14400.0, 21600.0, 43200.0),
)
_MARGIN_PX: Final = 60
"""Labels may be as far beyond the ends of an axis."""
_GAP_PX: Final = 4


def label_axis(kind: type[pg.AxisItem], side: str, view: pg.ViewBox, *, is_cached: bool = True) -> pg.AxisItem:
    """An axis of labels only."""
    axis = kind(side, linkView=view)
    axis.enableAutoSIPrefix(False)
    axis.setStyle(tickLength=0, tickAlpha=0, hideOverlappingLabels=_MARGIN_PX, autoExpandTextSpace=False)
    if is_cached:
        axis.setCacheMode(QGraphicsItem.CacheMode.DeviceCoordinateCache)
    return axis


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


def fitting_ticks(ticks: list[Tick], width_px: float, length_s: float) -> list[tuple[Tick, float, float]]:
    """The ticks whose labels touch none before them and are not left of the time line, where the first is moved for
    that; each with the left and the right end of its label."""
    metrics, second_px, free_from, fitting = QFontMetricsF(font(Size.SMALL)), width_px / length_s, 0.0, []
    for time_s, label in ticks:
        half = metrics.horizontalAdvance(label) / 2 + _GAP_PX / 2
        middle = width_px + time_s * second_px
        middle = half if middle < 1 else middle
        if middle - half >= free_from:
            free_from = middle + half + _GAP_PX
            fitting.append((((middle - width_px) / second_px, label), middle - half, middle + half))
    return fitting


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
