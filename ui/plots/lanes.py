"""What the plots show: lanes with their scales and limits, marks, and time spans. Times are monotonic seconds."""

from collections.abc import Callable
from typing import NamedTuple

from app.limits.out_of_limits import Outside
from app.samples.ring_buffers import Extent, Readable
from app.samples.step_function import StepFunction
from app.text.i18n import tr
from protocol.translatable import marked
from ui.style.icons import Icon
from ui.style.theme import Meaning


class Span(NamedTuple):
    start_s: float
    end_s: float

    @property
    def length_s(self) -> float:
        return self.end_s - self.start_s


class Scale(NamedTuple):
    """A vertical scale with a line at every ``step``."""

    low: float
    high: float
    step: float


class Limit(NamedTuple):
    """A limit over time; `label` is English with `{value}`, `meaning` that of exceeding it.

    `stale` is the last known value while it is not confirmed.
    """

    steps: StepFunction
    label: str
    meaning: Meaning
    decimals: int = 0
    stale: StepFunction | None = None


class Lane(NamedTuple):
    """One plot of the stack.

    The first of `scales` that covers all values in sight is used, else the last. `weight` is the share of the height.
    The curve is interrupted where no sample came for more than `gap_s`.
    """

    title: str
    unit: str
    series: Readable
    scales: tuple[Scale, ...]
    limits: tuple[Limit, ...] = ()
    decimals: int = 0
    weight: float = 1.0
    gap_s: float = 1.0
    outside: Callable[[float, float], Outside | None] | None = None
    """Judges a value at a time."""


class Mark(NamedTuple):
    """An event; `word` is English. `rank` 0 is the most important, which others never hide."""

    time_s: float
    word: str
    icon: Icon
    meaning: Meaning | None = None
    rank: int = 0


Steps = tuple[StepFunction, StepFunction | None]
"""A limit over time, and what was last known of it."""


def tilt_lane(series: Readable, fires: Steps, rearms: Steps, *, gap_s: float = 1.0) -> Lane:
    limits = (
        Limit(fires[0], marked("{value}° fires"), Meaning.DANGER, stale=fires[1]),
        Limit(rearms[0], marked("{value}° rearms"), Meaning.INFORMATION, stale=rearms[1]),
    )
    return Lane(marked("Tilt"), "°", series, (Scale(0, 90, 30), Scale(0, 180, 45)), limits, weight=3, gap_s=gap_s)


def acceleration_lane(series: Readable, falls: Steps, *, gap_s: float = 1.0) -> Lane:
    limit = Limit(falls[0], marked("{value} g free fall"), Meaning.DANGER, 1, stale=falls[1])
    scales = Scale(0, 2, 1), Scale(0, 4, 2), Scale(0, 8, 4), Scale(0, 16, 8), Scale(0, 26, 13)
    return Lane(marked("Acceleration"), "g", series, scales, (limit,), decimals=1, weight=2, gap_s=gap_s)


def fitting_scale(scales: tuple[Scale, ...], low: float, high: float) -> Scale:
    """The first scale that covers both values, else the last."""
    return next((scale for scale in scales if scale.low <= low and high <= scale.high), scales[-1])


def value_text(value: float, decimals: int) -> str:
    """A value with a typographic minus sign."""
    return f"{value:.{decimals}f}".replace("-", "−")


class Reading(NamedTuple):
    """What is read at a time: its text, and the sample."""

    text: str
    near: Extent | None


def reading(lane: Lane, at_s: float) -> Reading:
    """The value at a time with its unit, a range where only that was kept, or "no data" where no curve is drawn."""
    near = lane.series.around(at_s, within_s=lane.gap_s / 2)
    if near is None:
        return Reading(tr("no data"), None)
    low, high = value_text(near.low, lane.decimals), value_text(near.high, lane.decimals)
    gap = "" if lane.unit == "°" else " "
    text = f"{low}{gap}{lane.unit}" if low == high else f"{low} … {high}{gap}{lane.unit}"
    outside = None if lane.outside is None else lane.outside(near.low, at_s) or lane.outside(near.high, at_s)
    return Reading(text if outside is None else outside.beside(text), near)
