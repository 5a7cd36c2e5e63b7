"""Ticks of the time axis and their labels."""

import math
import time
from typing import Final

from app.text.i18n import tr
from ui.plots.lanes import Span, Tick

# Distances between ticks, in seconds.
_STEPS_S: Final = (
    *(0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5),
    *(1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0, 7200.0),
    *(14400.0, 21600.0, 43200.0),
)


def before_now(length_s: float, *, most: int) -> list[Tick]:
    """Ticks counted back from the end of the span, so that they stay in place while it moves."""
    step_s = _step_s(length_s, most)
    count = math.floor(length_s / step_s + 1e-6)
    return [(-n * step_s, _ago(n * step_s, step_s)) for n in range(count + 1)]


def clock_times(span: Span, *, most: int, wall_offset_s: float) -> list[Tick]:
    """Ticks at round times of day; `wall_offset_s` added to a time gives seconds since 1970."""
    step_s = _step_s(span.length_s, most)
    first = math.ceil((span.start_s + wall_offset_s) / step_s)
    last = math.floor((span.end_s + wall_offset_s) / step_s)
    decimals = _decimals(step_s)
    end_s = span.end_s + wall_offset_s
    return [(n * step_s - end_s, clock_text(n * step_s, decimals)) for n in range(first, last + 1)]


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


def _ago(seconds: float, step_s: float) -> str:
    if seconds < step_s / 2:
        return tr("now")
    if step_s >= 60:
        return tr("−{minutes} min", minutes=f"{seconds / 60:g}")
    return ago_text(seconds, _decimals(step_s))


def _step_s(length_s: float, most: int) -> float:
    return next((step for step in _STEPS_S if length_s / step <= most), _STEPS_S[-1])


def _decimals(step_s: float) -> int:
    return max(0, math.ceil(-math.log10(step_s) - 1e-9)) if step_s < 1 else 0
