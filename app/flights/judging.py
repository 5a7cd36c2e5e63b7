"""Where a flight would have fired, under either reading of the vendor's rule; whether its log says enough for a no, and
when control was lost.

The first firing is computed once for every threshold in the vendor's steps, in a worker process; after that thresholds
are a look-up.
"""

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from functools import reduce
from operator import or_
from typing import Final, NamedTuple

import numpy as np

from app.flights.flight_log import GAP_TOLERANCE_S, FlightLog, runs, total_s
from app.flights.judge import MAX_GAP_S, ROUNDING_S, TriggerLimits
from app.flights.raw_log import Flags, Floats, Places
from app.text.i18n import tr
from app.text.messages import UserMessage, message, stopwatch
from protocol.catalogue import CENTISECOND, DEGREE, TENTH_G
from protocol.messages import Source
from protocol.translatable import marked

MAX_TILT_STEPS: Final = 180
"""Whole degrees; the largest possible tilt."""
MAX_ACCELERATION_STEPS: Final = 15
"""Tenths of g; above 1.5 g everything would be a fall."""
MAX_TIME_STEPS: Final = 255
"""Hundredths of a second: the byte's largest."""
NEVER: Final = math.inf
EVER: Final = sys.float_info.max
"""After any firing; what never fires is later still."""
DAMPING_S: Final = 0.2
"""Damped reading: how long the angle must last, and the averaging time of the acceleration."""
FALL_MARGIN_S: Final = 0.1
"""A pause in which a fall that is shorter by this than the free-fall time fits may hide one that fires."""
MAX_MISSING_SHARE: Final = 0.1
"""Of the flight, or of the samples, above which its rest proves nothing."""


class RuleReading(Enum):
    """Interpretation of what the vendor's rule leaves open; the value describes it."""

    # As `app.flights.judge.Judge` and the simulated module do.
    DIRECT = marked("angle at once, acceleration unfiltered")
    DAMPED = marked("angle lasts 0.2 s, acceleration averaged over 0.2 s")


class Samples(NamedTuple):
    """One quantity at the module's resolution, where it is known.

    Where it is not active, as on the ground, the module does not judge, and forgets what was.
    """

    time_s: Floats
    values: Floats
    is_active: Flags


def tilts_of(log: FlightLog, reading: RuleReading) -> Samples:
    """In degrees."""
    rows = np.flatnonzero(np.isfinite(log.tilt_deg))
    tilt_deg = log.tilt_deg[rows]
    if reading is RuleReading.DAMPED:
        tilt_deg = lasting(log.time_s[rows], tilt_deg)
        rows, tilt_deg = rows[np.isfinite(tilt_deg)], tilt_deg[np.isfinite(tilt_deg)]
    return Samples(log.time_s[rows], to_steps(tilt_deg, DEGREE.per_unit), log.is_judged[rows])


def forces_of(log: FlightLog, reading: RuleReading) -> Samples:
    """In g."""
    rows = np.flatnonzero(np.isfinite(log.specific_force_g))
    force_g = log.specific_force_g[rows]
    if reading is RuleReading.DAMPED:
        force_g = averaged(log.time_s[rows], force_g, DAMPING_S)
    return Samples(log.time_s[rows], to_steps(force_g, TENTH_G.per_unit), log.is_judged[rows])


def to_steps(values: Floats, per_unit: int) -> Floats:
    """Rounds to the steps that the module reports in a byte."""
    steps: Floats = np.clip(np.rint(values * per_unit), 0, 255) / per_unit
    return steps


def lasting(time_s: Floats, tilt_deg: Floats) -> Floats:
    """Minimum of the last `DAMPING_S`; NaN until that much time has passed since a pause."""
    if not len(time_s):
        return tilt_deg
    # `reduceat` takes the minimum between each bound and the next: every second one is of a window.
    bounds = np.column_stack((_window_firsts(time_s, DAMPING_S), np.arange(1, len(time_s) + 1))).ravel()
    minima: Floats = np.minimum.reduceat(np.append(tilt_deg, np.inf), bounds)[::2]
    minima[time_s - time_s[_stretch_firsts(time_s)] < DAMPING_S - ROUNDING_S] = np.nan
    return minima


def averaged(time_s: Floats, values: Floats, over_s: float) -> Floats:
    """Mean of the last `over_s`, both ends included, since a pause."""
    sums = np.concatenate(((0.0,), np.cumsum(values)))
    firsts, stops = _window_firsts(time_s, over_s), np.arange(1, len(values) + 1)
    mean: Floats = (sums[stops] - sums[firsts]) / (stops - firsts)
    return mean


def _window_firsts(time_s: Floats, over_s: float) -> Places:
    """For each row the first row of the last `over_s` since a pause."""
    firsts = np.searchsorted(time_s, time_s - (over_s + ROUNDING_S), "left")
    return np.maximum(firsts, _stretch_firsts(time_s))


def _stretch_firsts(time_s: Floats) -> Places:
    """For each row the first row after the last pause."""
    is_first = np.diff(time_s, prepend=-np.inf) > MAX_GAP_S
    firsts: Places = np.maximum.accumulate(np.where(is_first, np.arange(len(time_s)), 0))
    return firsts


# What fires


class Firing(NamedTuple):
    """The tilt in whole degrees, as a module reports it; NaN where the log has none."""

    at_s: float
    source: Source
    tilt_deg: float


@dataclass(frozen=True, slots=True, eq=False)
class FiringCurves:
    """Of one flight under one reading. Times are seconds of the `FlightLog`, `NEVER` where nothing fires."""

    # First firing of the attitude trigger, by threshold in whole degrees, and the tilt then: shape (181,).
    attitude_s: Floats
    attitude_deg: Floats
    # First firing of the free-fall trigger, by threshold in tenths of g and time in hundredths of a second, and the
    # tilt then, NaN where it is unknown: (16, 256).
    freefall_s: Floats
    freefall_deg: Floats
    # Longest fall from first to last report, by threshold in tenths of g; -1 where there is none: (16,).
    longest_fall_s: Floats

    def firings(self, limits: TriggerLimits) -> list[Firing]:
        """The first one of each trigger, in order of time: after it the parachute is open.

        Raises LookupError for a free-fall acceleration above 1.5 g.
        """
        found: list[Firing] = []
        tilt = steps_of(limits.attitude_threshold_deg, DEGREE.per_unit)
        if limits.attitude_is_enabled and tilt <= MAX_TILT_STEPS:
            found.append(Firing(float(self.attitude_s[tilt]), Source.ATTITUDE, float(self.attitude_deg[tilt])))
        if limits.freefall_is_enabled:
            fall = acceleration_step(limits), steps_of(limits.freefall_time_s, CENTISECOND.per_unit)
            found.append(Firing(float(self.freefall_s[fall]), Source.FREEFALL, float(self.freefall_deg[fall])))
        return sorted((firing for firing in found if firing.at_s < NEVER), key=lambda firing: firing.at_s)

    def first(self, limits: TriggerLimits) -> tuple[float, Source]:
        """When it fires first, and why; `NEVER` and nothing where it does not. Raises as `firings`."""
        found = self.firings(limits)
        first_s = found[0].at_s if found else NEVER
        return first_s, reduce(or_, (firing.source for firing in found if firing.at_s == first_s), Source(0))


def steps_of(value: float, per_unit: int) -> int:
    return round(value * per_unit)


def acceleration_step(limits: TriggerLimits) -> int:
    """Raises LookupError for a free-fall acceleration above 1.5 g."""
    step = steps_of(limits.freefall_acceleration_g, TENTH_G.per_unit)
    if step > MAX_ACCELERATION_STEPS:
        raise LookupError(limits.freefall_acceleration_g)
    return step


def firing_curves(log: FlightLog, reading: RuleReading) -> FiringCurves:
    """Takes about 10 ms for a flight of ten minutes."""
    tilts = tilts_of(log, reading)
    highest_deg = np.maximum.accumulate(tilts.values[tilts.is_active])
    rows = np.searchsorted(highest_deg, np.arange(MAX_TILT_STEPS + 1), "left")
    attitude_s = np.append(tilts.time_s[tilts.is_active], NEVER)[rows]
    freefall_s = np.full((MAX_ACCELERATION_STEPS + 1, MAX_TIME_STEPS + 1), NEVER)
    longest_fall_s = np.full(MAX_ACCELERATION_STEPS + 1, -1.0)
    time_s, forces_g, is_active = forces_of(log, reading)
    steps = np.where(is_active, np.rint(forces_g * TENTH_G.per_unit), np.inf)
    # A fall begins again after a pause, and where the module lost its state.
    restarts = np.diff(time_s, prepend=-np.inf) > MAX_GAP_S
    lost = np.searchsorted(time_s, [reset.time_s for reset in log.resets])
    restarts[lost[lost < len(time_s)]] = True
    times_s = np.arange(MAX_TIME_STEPS + 1) / CENTISECOND.per_unit - ROUNDING_S
    for step in range(1, MAX_ACCELERATION_STEPS + 1):
        firsts, lasts = runs(steps < step, restarts)
        if len(firsts):
            lasted_s = time_s[lasts] - time_s[firsts]
            longest_fall_s[step] = lasted_s.max()
            # For each free-fall time the first fall that lasts so long, and the first row at which it has done so.
            fall = np.searchsorted(np.maximum.accumulate(lasted_s), times_s, "left")
            is_there = fall < len(firsts)
            rows = np.searchsorted(time_s, time_s[firsts[fall[is_there]]] + times_s[is_there], "left")
            freefall_s[step, is_there] = time_s[rows]
    measured_deg = np.append(to_steps(log.tilt_deg, DEGREE.per_unit), np.nan)
    attitude_deg, freefall_deg = (measured_deg[np.searchsorted(log.time_s, at_s)] for at_s in (attitude_s, freefall_s))
    return FiringCurves(attitude_s, attitude_deg, freefall_s, freefall_deg, longest_fall_s)


# What is missing


class Answer(Enum):
    """Would it have fired? The value is its word in JSON."""

    FIRES = "fires"
    DOES_NOT_FIRE = "does_not_fire"
    NOT_JUDGED = "not_judged"
    UNREADABLE = "unreadable"


@dataclass(frozen=True, slots=True, eq=False)
class Coverage:
    """Why too little of one flight is known, computed once for all thresholds; None: enough. See `coverage_of`.

    What is missing is never taken for a calm flight.
    """

    why_not: UserMessage | None
    why_no_attitude: UserMessage | None
    why_no_acceleration: UserMessage | None
    # The longest fall that a pause may hide, with the falls around it, by threshold in tenths of g: shape (16,).
    hidden_fall_s: Floats

    def why_not_enough(self, limits: TriggerLimits) -> UserMessage | None:
        """Why a flight in which nothing fires with these thresholds is not judged; None where it is."""
        if self.why_not is not None:
            return self.why_not
        if limits.attitude_is_enabled and self.why_no_attitude is not None:
            return self.why_no_attitude
        if not limits.freefall_is_enabled:
            return None
        longest_s = limits.freefall_time_s - FALL_MARGIN_S + GAP_TOLERANCE_S
        if float(self.hidden_fall_s[acceleration_step(limits)]) > longest_s:
            return message(marked("A pause of the acceleration may hide a fall."))
        return self.why_no_acceleration


def coverage_of(log: FlightLog) -> Coverage:
    """Time on the ground is not missing."""
    why_not = why_no_attitude = why_no_acceleration = None
    if not log.has_plausible_length:
        why_not = message(marked("No flight has the length of this log."))
    elif log.left_out_share > MAX_MISSING_SHARE:
        why_not = message(marked("More than a tenth of the samples was left out."))
    if len(log.tilt_gaps):
        why_no_attitude = message(marked("A pause of the attitude of more than 0.2 s may hide a tilt."))
    if total_s(log.force_gaps) > MAX_MISSING_SHARE * total_s(log.flights):
        why_no_acceleration = message(marked("More than a tenth of the acceleration is missing."))
    return Coverage(why_not, why_no_attitude, why_no_acceleration, _hidden_falls(log))


def _hidden_falls(log: FlightLog) -> Floats:
    """Each pause may be a fall, which began with the rows below the threshold before it and ends with those behind."""
    hidden_s = np.zeros(MAX_ACCELERATION_STEPS + 1)
    begins_s, ends_s = log.force_gaps.T
    if not len(begins_s):
        return hidden_s
    known = forces_of(log, RuleReading.DIRECT)
    steps = np.rint(known.values * TENTH_G.per_unit)
    for step in range(MAX_ACCELERATION_STEPS + 1):
        # No fall goes on over a row that has weight, or over the ground.
        has_weight = (steps >= step) & known.is_active
        bounds_s = np.sort(np.concatenate((known.time_s[has_weight], log.flights.ravel())))
        before = np.searchsorted(bounds_s, begins_s, "right") - 1
        behind = np.searchsorted(bounds_s, ends_s, "left")
        hidden_s[step] = (bounds_s[behind] - bounds_s[before]).max()
    return hidden_s


# The summary of a flight

CALM_S: Final = 1.0
CALM_TILT_DEG: Final = 30.0
CALM_G: Final = (0.5, 1.5)
IMPACT_G: Final = 3.0
MIN_LOSS_S: Final = 0.3
"""A calm flight until less than this before the impact was a hard landing."""
BOUNCE_S: Final = 2.0
"""Peaks within this time are one impact."""
REST_M: Final = 2.0
"""Altitudes within this of the last one are those of an aircraft that flew no more."""


class FirstFire(NamedTuple):
    """First firing of one flight with given thresholds, under one reading."""

    # Time of the `FlightLog`; infinite where it does not fire.
    at_s: float
    sources: Source
    # It fires before the impact.
    is_in_time: bool
    # After the loss of control, negative before it; NaN where unknown.
    delay_s: float

    @property
    def late_text(self) -> str:
        """How late it is, translated; empty where unknown."""
        if math.isnan(self.delay_s):
            return ""
        if self.delay_s < 0:  # it flew on: nothing tells that control was lost when it fired
            return tr("then calm again until {time}", time=moment_text(self.at_s - self.delay_s))
        return tr("{delay:.2f} s after the loss of control", delay=self.delay_s)


def moment_text(at_s: float) -> str:
    """Time since the beginning of the log: "12.3 s", "3:07.2"."""
    return f"{at_s:.1f} s" if at_s < 60 else f"{stopwatch(at_s)}.{int(at_s * 10) % 10}"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightSummary:
    """One flight; times are those of its `FlightLog`, which is read again to show it."""

    # Path of the file as given.
    name: str
    duration_s: float
    not_judged_s: float
    # As measured, of the judged rows; NaN without any.
    tilt_max_deg: float
    # The log holds an attitude, or an acceleration, while it is judged.
    has_attitude: bool
    has_acceleration: bool
    coverage: Coverage
    curves: Mapping[RuleReading, FiringCurves]
    # Estimated loss of control; None: not lost, or unknown.
    loss_s: float | None
    # None: unknown.
    impact_s: float | None
    problems: tuple[UserMessage, ...]

    @property
    def end_s(self) -> float:
        """Time after which firing is too late: the impact, `EVER` where unknown."""
        return EVER if self.impact_s is None else self.impact_s

    def first_fire(self, limits: TriggerLimits, reading: RuleReading = RuleReading.DIRECT) -> FirstFire:
        """Raises LookupError for a free-fall acceleration above 1.5 g."""
        at_s, sources = self.curves[reading].first(limits)
        delay_s = at_s - self.loss_s if sources and self.loss_s is not None else math.nan
        return FirstFire(at_s, sources, at_s <= self.end_s, delay_s)

    def answer(self, limits: TriggerLimits) -> Answer:
        """Would it have fired? Raises LookupError for a free-fall acceleration above 1.5 g."""
        _, sources = self.curves[RuleReading.DIRECT].first(limits)
        if sources:
            return Answer.FIRES
        return Answer.DOES_NOT_FIRE if self.coverage.why_not_enough(limits) is None else Answer.NOT_JUDGED

    def longest_fall_s(self, limits: TriggerLimits) -> float:
        """From first to last report below their acceleration, unfiltered; -1 without any. Raises LookupError."""
        return float(self.curves[RuleReading.DIRECT].longest_fall_s[acceleration_step(limits)])


def summarise(log: FlightLog) -> FlightSummary:
    """Takes about 15 ms for a flight of ten minutes."""
    lost = loss_of_control(log)
    tilts_deg = log.tilt_deg[log.is_judged & np.isfinite(log.tilt_deg)]
    return FlightSummary(
        name=log.name,
        duration_s=log.duration_s,
        not_judged_s=log.not_judged_s,
        tilt_max_deg=float(tilts_deg.max()) if len(tilts_deg) else math.nan,
        has_attitude=len(tilts_deg) > 0,
        has_acceleration=bool((log.is_judged & np.isfinite(log.specific_force_g)).any()),
        coverage=coverage_of(log),
        curves={reading: firing_curves(log, reading) for reading in RuleReading},
        loss_s=lost.loss_s,
        impact_s=lost.impact_s,
        problems=log.problems,
    )


# When it was lost


class LossOfControl(NamedTuple):
    """Times of the `FlightLog`; None where unknown."""

    # End of the last calm second in flight before the impact: tilt up to 30°, 0.5 to 1.5 g. An estimate.
    loss_s: float | None
    # First of the last peaks of 3 g or more, else when it came to rest.
    impact_s: float | None


def loss_of_control(log: FlightLog) -> LossOfControl:
    """`loss_s` is None for a flight that was calm to its end or landing."""
    is_known = log.is_judged & np.isfinite(log.tilt_deg) & np.isfinite(log.specific_force_g)
    force_g = log.specific_force_g
    is_calm = (log.tilt_deg <= CALM_TILT_DEG) & (force_g >= CALM_G[0]) & (force_g <= CALM_G[1])
    rest_s = _fell_to_rest(log, is_known, is_calm)
    if rest_s is not None:  # what moves it later is a hand
        is_known &= log.time_s <= rest_s + BOUNCE_S
    time_s, is_calm = log.time_s[is_known], is_calm[is_known]
    if not len(time_s):
        return LossOfControl(None, None)
    loss_s, end_s = _last_calm_end(time_s, is_calm), float(time_s[-1])
    impact_s = _first_of_last(time_s[force_g[is_known] >= IMPACT_G])
    if impact_s is None:
        impact_s = rest_s
    if impact_s is not None and loss_s is not None and loss_s > impact_s and end_s - loss_s >= MIN_LOSS_S:
        impact_s = None  # it flew on after that peak
    if impact_s is not None:
        is_before = time_s <= impact_s
        loss_s, end_s = _last_calm_end(time_s[is_before], is_calm[is_before]), impact_s
    if loss_s is not None and end_s - loss_s < MIN_LOSS_S:
        loss_s = None
    return LossOfControl(loss_s, impact_s)


def _fell_to_rest(log: FlightLog, is_known: Flags, is_calm: Flags) -> float | None:
    """From when on it stayed at its last altitude, if it was not calm when it came there; None where unknown."""
    if log.altitude_m is None:
        return None
    rows = np.flatnonzero(np.isfinite(log.altitude_m))
    away = np.flatnonzero(np.abs(log.altitude_m[rows] - log.altitude_m[rows[-1:]]) > REST_M)
    if not len(away):
        return None
    rest_s = float(log.time_s[rows[away[-1]]])
    before = is_known & (log.time_s > rest_s - CALM_S) & (log.time_s <= rest_s)
    return rest_s if before.any() and not is_calm[before].any() else None


def _first_of_last(peaks_s: Floats) -> float | None:
    """Of the last peaks, the first."""
    firsts = np.flatnonzero(np.diff(peaks_s, prepend=-np.inf) > BOUNCE_S)
    return float(peaks_s[firsts[-1]]) if len(firsts) else None


def _last_calm_end(time_s: Floats, is_calm: Flags) -> float | None:
    """End of the last run of calm rows of at least `CALM_S`."""
    firsts, lasts = runs(is_calm)
    is_long = time_s[lasts] - time_s[firsts] >= CALM_S
    return float(time_s[lasts[is_long][-1]]) if is_long.any() else None
