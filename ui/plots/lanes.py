"""What the plots show: lanes with their scales and limits, marks, and time spans. Times are monotonic seconds."""

import math
from collections.abc import Callable
from typing import Final, NamedTuple

from PySide6.QtCore import QObject, Signal

from app.limits.limits import LimitsInUse, Outside, cell_outside
from app.recordings.excerpt import LimitSteps, Measured
from app.recordings.markers import Marker, MarkerKind
from app.samples.samples import Readable, StepFunction
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
    """A vertical scale with a line at every `step`; 0: wherever there is room."""

    low: float
    high: float
    step: float


class Limit(NamedTuple):
    """A limit over time; `label` is English with `{value}`, `meaning` that of exceeding it. `is_stale`: what was last
    known of one that is not known to act, which is greyed."""

    steps: StepFunction
    label: str
    meaning: Meaning
    decimals: int = 0
    is_stale: bool = False


class Lane(NamedTuple):
    """One plot of the stack.

    The first of `scales` that covers all values in sight is used, else the last. `weight` is the share of the height.
    The curve is interrupted where no sample came for more than `gap_s`. `outside` judges a value at a time.
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


class Mark(NamedTuple):
    """An event; `word` is English. `rank` 0 is the most important, which others never hide."""

    time_s: float
    word: str
    icon: Icon
    meaning: Meaning | None = None
    rank: int = 0


# The most important first; where two are in one place, only the first is shown.
_MARKS: Final[dict[MarkerKind, tuple[str, Icon, Meaning | None]]] = {
    MarkerKind.TRIGGERED: (marked("triggered"), Icon.PARACHUTE, Meaning.DANGER),
    MarkerKind.RESTARTED: (marked("restarted"), Icon.RESTART, Meaning.ATTENTION),
    MarkerKind.CONTRADICTED: (marked("two modules?"), Icon.UNKNOWN, Meaning.ATTENTION),
    MarkerKind.ANOTHER: (marked("another module"), Icon.UNKNOWN, Meaning.INFORMATION),
    MarkerKind.ACTIVATED: (marked("activated"), Icon.ACTIVE, Meaning.ATTENTION),
    MarkerKind.LOCKED: (marked("locked"), Icon.LOCK, None),
    MarkerKind.PORT_LOST: (marked("port lost"), Icon.UNPLUGGED, Meaning.ATTENTION),
    MarkerKind.SILENT: (marked("silent"), Icon.LINK_LOST, Meaning.ATTENTION),
    MarkerKind.SLEPT: (marked("computer slept"), Icon.LINK_LOST, Meaning.ATTENTION),
    MarkerKind.DAMAGED: (marked("damaged data left out"), Icon.WARNING, Meaning.DANGER),
    MarkerKind.NAMED: (marked("named"), Icon.LABEL, None),
    MarkerKind.RATE_CHANGED: (marked("baud rate changed"), Icon.LINK, None),
    MarkerKind.TRIGGER_ENDED: (marked("trigger ended"), Icon.NOT_TRIGGERED, None),
    MarkerKind.CONNECTED: (marked("connected"), Icon.LINK, Meaning.INFORMATION),
}


def mark_of(marker: Marker) -> Mark:
    return Mark(marker.time_s, *_MARKS[marker.kind], list(_MARKS).index(marker.kind))


# A limit that the module acts on over time, and what was last known of it otherwise.
Steps = tuple[StepFunction, StepFunction | None]


def _limits(steps: Steps, label: str, stale_label: str, meaning: Meaning, decimals: int = 0) -> tuple[Limit, ...]:
    acting, stale = steps
    firm = Limit(acting, label, meaning, decimals)
    return (firm,) if stale is None else (firm, Limit(stale, stale_label, meaning, decimals, is_stale=True))


def tilt_lane(series: Readable, fires: Steps, rearms: Steps, *, gap_s: float = 1.0) -> Lane:
    limits = (
        *_limits(fires, marked("{value}° fires"), marked("{value}° fires?"), Meaning.DANGER),
        *_limits(rearms, marked("{value}° rearms"), marked("{value}° rearms?"), Meaning.INFORMATION),
    )
    return Lane(marked("Tilt"), "°", series, (Scale(0, 90, 30), Scale(0, 180, 45)), limits, weight=3, gap_s=gap_s)


def acceleration_lane(series: Readable, falls: Steps, *, gap_s: float = 1.0) -> Lane:
    limits = _limits(falls, marked("{value} g free fall"), marked("{value} g free fall?"), Meaning.DANGER, 1)
    scales = Scale(0, 2, 1), Scale(0, 4, 2), Scale(0, 8, 4), Scale(0, 16, 8), Scale(0, 26, 13)
    return Lane(marked("Acceleration"), "g", series, scales, limits, decimals=1, weight=2, gap_s=gap_s)


# Voltage and light count as fresh for 5 s.
SLOW_GAP_S: Final = 5.0


def measured_lanes(data: Measured, in_use: LimitsInUse, acting: LimitSteps, unproven: LimitSteps) -> tuple[Lane, ...]:
    """Make the lanes of a session or a recording, with the limits that act, and those of which that is not known."""

    def outside(volts: float, time_s: float) -> Outside | None:
        return cell_outside(volts, in_use.profile, is_charging=data.charging_at(time_s))

    lights = (acting.lights, unproven.lights)
    threshold = _limits(lights, marked("{value} V threshold"), marked("{value} V threshold?"), Meaning.ATTENTION, 1)
    light_scales = (Scale(0, 4, 2), Scale(0, 8, 4), Scale(0, 26, 13))
    return (
        tilt_lane(data.tilt, (acting.fires, unproven.fires), (acting.rearms, unproven.rearms)),
        acceleration_lane(data.acceleration, (acting.falls, unproven.falls)),
        Lane(marked("Light"), "V", data.light, light_scales, threshold, decimals=1, weight=1.2, gap_s=SLOW_GAP_S),
        Lane(
            marked("Cell voltage"),
            "V",
            data.cell,
            (Scale(3, 4.5, 0.5), Scale(0, 6, 2)),
            decimals=2,
            weight=1.2,
            gap_s=SLOW_GAP_S,
            outside=outside,
        ),
    )


def value_text(value: float, decimals: int) -> str:
    return f"{value:.{decimals}f}".replace("-", "−")


# The shortest span is some forty status frames at line rate, the longest what a series keeps.
_SHORTEST_S: Final = 0.03
_LONGEST_S: Final = 10 * 3600.0


class TimeRange(QObject):
    """The only place that moves span and cursor.

    Live the span ends now and is as long as was chosen; pausing, panning and zooming hold a span until `back_to_live`.
    `bounds` are those of a recording, which has no live end to follow; at first all of it is in sight.
    """

    changed = Signal()

    def __init__(self, bounds: Span | None) -> None:
        super().__init__()
        self.now_s = 0.0
        # Of the plots, in device pixels.
        self.width_px = 1.0
        # The place of the cursor within the span, 0 to 1.
        self.cursor: float | None = None
        self._live_s = 60.0
        self._held: Span | None = None
        self._bounds = bounds
        if bounds is not None and bounds.length_s < _SHORTEST_S:
            middle_s = (bounds.start_s + bounds.end_s) / 2
            self._bounds = Span(middle_s - _SHORTEST_S / 2, middle_s + _SHORTEST_S / 2)

    @property
    def is_recorded(self) -> bool:
        return self._bounds is not None

    @property
    def is_live(self) -> bool:
        return self._held is None and self._bounds is None

    @property
    def is_whole(self) -> bool:
        return self._bounds is not None and self.span.length_s >= self._bounds.length_s * (1 - 1e-9)

    @property
    def span(self) -> Span:
        return self.span_at(self.now_s)

    def span_at(self, now_s: float) -> Span:
        return self._held or self._bounds or self._live_span(now_s)

    def _live_span(self, now_s: float) -> Span:
        # It moves by whole pixels, so that lines do not flicker.
        pixel_s = self._live_s / self.width_px
        end_s = math.ceil(max(now_s, self.now_s) / pixel_s) * pixel_s
        return Span(end_s - self._live_s, end_s)

    @property
    def pixel_s(self) -> float:
        """Seconds per device pixel."""
        return self.span.length_s / self.width_px

    @property
    def cursor_s(self) -> float | None:
        return None if self.cursor is None else self.span.start_s + self.cursor * self.span.length_s

    def follow(self, now_s: float) -> None:
        """The newest samples are of this monotonic time."""
        self.now_s = max(self.now_s, now_s)

    # What a person does

    def toggle_pause(self) -> None:
        """Pauses, or goes back to live; no effect on a recording."""
        if self.is_live:
            self._hold(self.span)
        elif not self.is_recorded:
            self.back_to_live()

    def back_to_live(self) -> None:
        """Follows the newest samples in the chosen length, or shows all of a recording."""
        self._held = None
        self.changed.emit()

    def choose_length(self, length_s: float) -> None:
        """Sets the length of the time line; a held span keeps its end, that of a recording its middle."""
        span, self._live_s = self.span, length_s
        if self.is_live:
            self.changed.emit()
        else:
            end_s = span.end_s + ((length_s - span.length_s) / 2 if self.is_recorded else 0.0)
            self._hold(Span(end_s - length_s, end_s))

    def show_instant(self, time_s: float) -> None:
        length_s = min(self.span.length_s, self._live_s) if self.is_whole else self.span.length_s
        self._hold(Span(time_s - length_s / 2, time_s + length_s / 2))
        self.point_at(time_s)

    def pan(self, part: float) -> None:
        """By a part of the span, negative to the past."""
        span = self.span
        self._hold(Span(span.start_s + part * span.length_s, span.end_s + part * span.length_s))

    def zoom(self, factor: float, part: float) -> None:
        """Shows `factor` times as much time around a part of the span."""
        span = self.span
        factor = max(factor, _SHORTEST_S / span.length_s)
        start_s = span.start_s + part * (1 - factor) * span.length_s
        self._hold(Span(start_s, start_s + factor * span.length_s))

    def point(self, part: float | None) -> None:
        """Puts the cursor at a part of the span, or nowhere; in a recording, whose numbers it chooses, it stays."""
        if part is None and self.is_recorded:
            return
        part = None if part is None else min(1.0, max(0.0, part))
        if part != self.cursor:
            self.cursor = part
            self.changed.emit()

    def point_at(self, time_s: float) -> None:
        self.point((time_s - self.span.start_s) / self.span.length_s)

    def _hold(self, span: Span) -> None:
        """Shows `span`, as far as there are data."""
        live_end_s = self._live_span(self.now_s).end_s
        first_s, last_s = self._bounds or (live_end_s - _LONGEST_S, live_end_s)
        length_s = min(span.length_s, last_s - first_s)
        end_s = max(min(span.end_s, last_s), first_s + length_s)
        self._held = Span(end_s - length_s, end_s)
        self.changed.emit()
