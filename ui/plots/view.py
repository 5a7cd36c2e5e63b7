"""View model of the plots: lanes, limits, markers and the visible time span. Times are monotonic seconds."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, NamedTuple

from app.limits.out_of_limits import Outside
from app.samples.ring_buffers import Readable
from app.samples.step_function import StepFunction
from ui.style.icons import Icon
from ui.style.theme import Meaning

# Selectable lengths of the time line.
WINDOWS_S: Final = (10.0, 60.0, 600.0)
# Limit of zooming in: some forty status frames at line rate.
SHORTEST_S: Final = 0.03
# Limit of panning back: what a series keeps.
MAX_S: Final = 10 * 3600.0


class Span(NamedTuple):
    """A time span."""

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


@dataclass(frozen=True, slots=True)
class Limit:
    """A limit over time; `label` is English with `{value}`, `meaning` that of exceeding it.

    A draft is a value being tried, not one of the module. `stale` is the last known value while it is not confirmed.
    """

    steps: StepFunction
    label: str
    meaning: Meaning
    decimals: int = 0
    is_draft: bool = False
    stale: StepFunction | None = None


@dataclass(frozen=True, slots=True)
class Lane:
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


@dataclass(frozen=True, slots=True)
class Mark:
    """An event; `word` is English. `rank` 0 is the most important, which others never hide."""

    time_s: float
    word: str
    icon: Icon
    meaning: Meaning | None = None
    rank: int = 0


class TimeView:
    """The span in sight: the last `window_s` while it is live, else the one that was held.

    Pausing, zooming and panning hold the span until `follow_live`. A recording (`bounds`) is never live; at first all
    of it is in sight.
    """

    def __init__(self, window_s: float = WINDOWS_S[1], *, bounds: Span | None = None) -> None:
        self.window_s = window_s
        self._bounds = None if bounds is None else _at_least(bounds, SHORTEST_S)
        self._held: Span | None = None

    @property
    def is_live(self) -> bool:
        """Whether it follows the newest samples."""
        return self._held is None and self._bounds is None

    @property
    def is_recorded(self) -> bool:
        """Whether it shows a recording."""
        return self._bounds is not None

    @property
    def is_whole(self) -> bool:
        """Whether all of a recording is in sight."""
        if self._bounds is None or self._held is None:
            return self._bounds is not None
        return self._held.length_s >= self._bounds.length_s * (1 - 1e-9)

    def span(self, now_s: float) -> Span:
        """The span in sight."""
        return self._held or self._bounds or Span(now_s - self.window_s, now_s)

    def behind_s(self, now_s: float) -> float:
        """How far the span is behind now; 0 while it is live."""
        return 0.0 if self._held is None or self.is_recorded else max(0.0, now_s - self._held.end_s)

    def choose(self, window_s: float, *, now_s: float) -> None:
        """Sets the length; a held span keeps its end, that of a recording its middle."""
        self.window_s = window_s
        if self.is_recorded:
            start_s, end_s = self.span(now_s)
            middle_s = (start_s + end_s) / 2
            self._hold(Span(middle_s - window_s / 2, middle_s + window_s / 2), now_s)
        elif self._held is not None:
            self._hold(Span(self._held.end_s - window_s, self._held.end_s), now_s)

    def hold(self, now_s: float) -> None:
        """Pauses."""
        if self._held is None:
            self._held = self.span(now_s)

    def follow_live(self) -> None:
        """Goes back to live in the chosen length, or to all of a recording."""
        self._held = None

    def pan(self, by_s: float, *, now_s: float) -> None:
        """Moves by seconds, negative to the past, not beyond now."""
        start_s, end_s = self.span(now_s)
        self._hold(Span(start_s + by_s, end_s + by_s), now_s)

    def zoom(self, factor: float, *, at_s: float, now_s: float) -> None:
        """Shows `factor` times as much time; `at_s` keeps its place."""
        start_s, end_s = self.span(now_s)
        length_s = min(self._longest_s, max(SHORTEST_S, (end_s - start_s) * factor))
        part = (at_s - start_s) / (end_s - start_s)
        self._hold(Span(at_s - part * length_s, at_s + (1 - part) * length_s), now_s)

    def show_instant(self, time_s: float, *, now_s: float) -> None:
        """Holds the span with `time_s` in the middle, as far as the data go; the length stays."""
        length_s = self.span(now_s).length_s
        if self.is_whole:
            length_s = min(length_s, self.window_s)
        self._hold(Span(time_s - length_s / 2, time_s + length_s / 2), now_s)

    @property
    def _longest_s(self) -> float:
        return MAX_S if self._bounds is None else self._bounds.length_s

    def _hold(self, wanted: Span, now_s: float) -> None:
        length_s = min(wanted.length_s, self._longest_s)
        first_s, last_s = self._bounds or (now_s - MAX_S, now_s)
        end_s = max(min(wanted.end_s, last_s), first_s + length_s)
        self._held = Span(end_s - length_s, end_s)


def _at_least(span: Span, length_s: float) -> Span:
    """`span`, extended around its middle to at least `length_s`."""
    middle_s = (span.start_s + span.end_s) / 2
    return span if span.length_s >= length_s else Span(middle_s - length_s / 2, middle_s + length_s / 2)


def fitting_scale(scales: tuple[Scale, ...], low: float, high: float) -> Scale:
    """The first scale that covers both values, else the last."""
    return next((one for one in scales if one.low <= low and high <= one.high), scales[-1])
