"""Where a flight would have fired, whether its log says enough for a no, when control was lost; and which thresholds
separate flights that must fire from those that must not.

The first firing is computed once for every threshold in the vendor's steps; after that thresholds are a look-up. A
proposal can kill, so it stays within the narrow bounds of this program. No flight fires that must not, and each fires
before the impact that must. Flights of one side alone propose nothing.
"""

import math
import sys
from collections.abc import Mapping, Sequence
from enum import Enum
from functools import reduce
from operator import or_
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from app.flights.flight_log import GAP_TOLERANCE_S, Flags, FlightLog, Floats, Spans, runs, total_s
from app.flights.judge import MAX_GAP_S, ROUNDING_S, TriggerLimits
from app.safety.consequences import SHORT_FALL_S
from app.text.messages import UserMessage, message
from protocol.catalogue import CENTISECOND, DEGREE, TENTH_G
from protocol.messages import Source
from protocol.translatable import marked

# Whole degrees, tenths of g and hundredths of a second: the largest tilt, what would make everything a fall, a byte.
MAX_TILT_STEPS: Final = 180
MAX_ACCELERATION_STEPS: Final = 15
MAX_TIME_STEPS: Final = 255
NEVER: Final = math.inf
# After any firing; what never fires is later still.
EVER: Final = sys.float_info.max
_PER_UNIT: Final = (DEGREE.per_unit, TENTH_G.per_unit, CENTISECOND.per_unit)


class Answer(Enum):
    """Would it have fired? The value is its word in JSON."""

    FIRES = "fires"
    DOES_NOT_FIRE = "does_not_fire"
    NOT_JUDGED = "not_judged"
    UNREADABLE = "unreadable"


class Firing(NamedTuple):
    """The tilt in whole degrees, as a module reports it; NaN where the log has none."""

    at_s: float
    source: Source
    tilt_deg: float


class FlightOutcome(NamedTuple):
    """The effect of given thresholds in one flight."""

    answer: Answer
    # Why it is not judged.
    why_not: UserMessage | None
    # The first firing, in seconds of the log; `NEVER` and nothing where it does not fire.
    at_s: float
    sources: Source
    is_before_impact: bool


class FlightSummary:
    """One flight; times are those of its `FlightLog`, which is read again to show it. Of ten minutes it takes 10 ms.

    Methods raise LookupError for a free-fall acceleration above 1.5 g.
    """

    def __init__(self, log: FlightLog) -> None:
        self.name, self.duration_s, self.not_judged_s = log.name, log.duration_s, log.not_judged_s
        self.problems = log.problems
        # Estimated loss of control and impact; None: there was none, or unknown.
        self.loss_s, self.impact_s = loss_of_control(log)
        judged_deg = log.tilt_deg[log.is_judged & np.isfinite(log.tilt_deg)]
        # As measured, of the judged rows; NaN without any.
        self.tilt_max_deg = float(judged_deg.max()) if len(judged_deg) else math.nan
        # The attitude trigger fires at once, with the first tilt that reaches its threshold: when it fires first, by
        # threshold in whole degrees, shape (181,).
        tilts = samples_of(log, log.tilt_deg, DEGREE.per_unit)
        highest_deg = np.maximum.accumulate(tilts.steps[tilts.is_active])
        rows = np.searchsorted(highest_deg, np.arange(MAX_TILT_STEPS + 1), "left")
        self.attitude_s: Floats = np.append(tilts.time_s[tilts.is_active], NEVER)[rows]
        # The same of the free-fall trigger, by threshold in tenths of g and time in hundredths of a second, (16, 256);
        # and the longest fall from first to last report by threshold, -1 where there is none, (16,).
        forces = samples_of(log, log.specific_force_g, TENTH_G.per_unit)
        self.freefall_s, self.longest_falls_s = _falls(log, forces)
        # The log holds an acceleration while it is judged.
        self.has_acceleration = bool(forces.is_active.any())
        # The tilt when they fire; NaN where it is unknown.
        measured_deg = np.append(_to_steps(log.tilt_deg, DEGREE.per_unit), np.nan)
        self.attitude_deg: Floats = measured_deg[np.searchsorted(log.time_s, self.attitude_s)]
        self.freefall_deg: Floats = measured_deg[np.searchsorted(log.time_s, self.freefall_s)]
        # What is missing is never taken for a calm flight; time on the ground is not missing.
        tilt_gaps, force_gaps = log.gaps
        self.has_plausible_length, self.left_out_share = log.has_plausible_length, log.left_out_share
        self.has_tilt_gap = len(tilt_gaps) > 0
        self.lacks_acceleration = total_s(force_gaps) > 0.1 * total_s(log.flights)
        # The longest fall that a pause may hide, with the falls around it, by threshold, (16,).
        self.hidden_falls_s = _hidden_falls(log, forces, force_gaps)

    @property
    def end_s(self) -> float:
        """Time after which firing is too late: the impact, `EVER` where unknown."""
        return EVER if self.impact_s is None else self.impact_s

    def firings(self, limits: TriggerLimits) -> list[Firing]:
        """The first one of each trigger, in order of time: after it the parachute is open."""
        found: list[Firing] = []
        tilt, acceleration, time = steps_of(limits)
        if limits.attitude_is_enabled and tilt <= MAX_TILT_STEPS:
            found.append(Firing(float(self.attitude_s[tilt]), Source.ATTITUDE, float(self.attitude_deg[tilt])))
        if limits.freefall_is_enabled:
            at_s, tilt_deg = self.freefall_s[acceleration, time], self.freefall_deg[acceleration, time]
            found.append(Firing(float(at_s), Source.FREEFALL, float(tilt_deg)))
        return sorted((firing for firing in found if firing.at_s < NEVER), key=lambda firing: firing.at_s)

    def outcome(self, limits: TriggerLimits) -> FlightOutcome:
        """Would it have fired?"""
        found = self.firings(limits)
        if found:
            at_s = found[0].at_s
            sources = reduce(or_, (firing.source for firing in found if firing.at_s == at_s))
            return FlightOutcome(Answer.FIRES, None, at_s, sources, at_s <= self.end_s)
        why_not = self._why_not_judged(limits)
        answer = Answer.DOES_NOT_FIRE if why_not is None else Answer.NOT_JUDGED
        return FlightOutcome(answer, why_not, NEVER, Source(0), is_before_impact=False)

    def _why_not_judged(self, limits: TriggerLimits) -> UserMessage | None:
        """Why too little of it is known for a no; None: enough."""
        if not self.has_plausible_length:
            return message(marked("No flight has the length of this log."))
        if self.left_out_share > 0.1:
            return message(marked("More than a tenth of the samples was left out."))
        if limits.attitude_is_enabled and self.has_tilt_gap:
            return message(marked("A pause of the attitude of more than 0.2 s may hide a tilt."))
        # A pause hides one that fires also where the fall in it is a little shorter.
        hidden_s, longest_s = self.hidden_falls_s[steps_of(limits)[1]], limits.freefall_time_s - 0.1 + GAP_TOLERANCE_S
        if limits.freefall_is_enabled and hidden_s > longest_s:
            return message(marked("A pause of the acceleration may hide a fall."))
        if limits.freefall_is_enabled and self.lacks_acceleration:
            return message(marked("More than a tenth of the acceleration is missing."))
        return None

    def longest_fall_s(self, limits: TriggerLimits) -> float:
        """From first to last report below their acceleration; -1 without any."""
        return float(self.longest_falls_s[steps_of(limits)[1]])


def steps_of(limits: TriggerLimits) -> tuple[int, ...]:
    """The three thresholds in the vendor's steps."""
    return tuple(round(value * per_unit) for value, per_unit in zip(limits[:3], _PER_UNIT, strict=True))


class Samples(NamedTuple):
    """One quantity in the steps of a byte that the module reports, where it is known.

    Where it is not active, as on the ground, the module does not judge, and forgets what was.
    """

    time_s: Floats
    steps: Floats
    is_active: Flags


def samples_of(log: FlightLog, values: Floats, per_unit: int) -> Samples:
    """`values`: of each row."""
    rows = np.flatnonzero(np.isfinite(values))
    return Samples(log.time_s[rows], _to_steps(values[rows], per_unit), log.is_judged[rows])


def _to_steps(values: Floats, per_unit: int) -> Floats:
    return np.clip(np.rint(values * per_unit), 0, 255)


def _falls(log: FlightLog, forces: Samples) -> tuple[Floats, Floats]:
    """`freefall_s` and `longest_falls_s` of the summary."""
    freefall_s = np.full((MAX_ACCELERATION_STEPS + 1, MAX_TIME_STEPS + 1), NEVER)
    longest_falls_s = np.full(MAX_ACCELERATION_STEPS + 1, -1.0)
    time_s = forces.time_s
    steps = np.where(forces.is_active, forces.steps, np.inf)
    # A fall begins again after a pause, and where the module lost its state.
    restarts = np.diff(time_s, prepend=-np.inf) > MAX_GAP_S
    lost = np.searchsorted(time_s, log.resets_s)
    restarts[lost[lost < len(time_s)]] = True
    times_s = np.arange(MAX_TIME_STEPS + 1) / CENTISECOND.per_unit - ROUNDING_S
    for step in range(1, MAX_ACCELERATION_STEPS + 1):
        firsts, lasts = runs(steps < step, restarts)
        if not len(firsts):
            continue
        lasted_s = time_s[lasts] - time_s[firsts]
        longest_falls_s[step] = lasted_s.max()
        # For each free-fall time the first fall that lasts so long, and the first row at which it has done so.
        fall = np.searchsorted(np.maximum.accumulate(lasted_s), times_s, "left")
        is_there = fall < len(firsts)
        rows = np.searchsorted(time_s, time_s[firsts[fall[is_there]]] + times_s[is_there], "left")
        freefall_s[step, is_there] = time_s[rows]
    return freefall_s, longest_falls_s


def _hidden_falls(log: FlightLog, forces: Samples, gaps: Spans) -> Floats:
    """Each pause may be a fall, which began with the rows below the threshold before it and ends with those behind."""
    hidden_s = np.zeros(MAX_ACCELERATION_STEPS + 1)
    begins_s, ends_s = gaps.T
    for step in range(MAX_ACCELERATION_STEPS + 1) if len(gaps) else ():
        # No fall goes on over a row that has weight, or over the ground.
        has_weight = (forces.steps >= step) & forces.is_active
        bounds_s = np.sort(np.concatenate((forces.time_s[has_weight], log.flights.ravel())))
        before = np.searchsorted(bounds_s, begins_s, "right") - 1
        behind = np.searchsorted(bounds_s, ends_s, "left")
        hidden_s[step] = (bounds_s[behind] - bounds_s[before]).max()
    return hidden_s


# When control was lost

_CALM_S: Final = 1.0
_CALM_TILT_DEG: Final = 30.0
_CALM_G: Final = (0.5, 1.5)
_IMPACT_G: Final = 3.0
# A calm flight until less than this before the impact was a hard landing.
_MIN_LOSS_S: Final = 0.3
# Peaks within this time are one impact.
_BOUNCE_S: Final = 2.0
# Altitudes within this of the last one are those of an aircraft that flew no more.
_REST_M: Final = 2.0


def loss_of_control(log: FlightLog) -> tuple[float | None, float | None]:
    """Estimates when control was lost and when it hit the ground; None where unknown, or calm to its end or landing.

    It is lost with the end of the last calm second in flight before the impact: tilt up to 30°, 0.5 to 1.5 g. The
    impact is the first of the last peaks of 3 g or more, else when it came to rest.
    """
    is_known = log.is_judged & np.isfinite(log.tilt_deg) & np.isfinite(log.specific_force_g)
    force_g = log.specific_force_g
    is_calm = (log.tilt_deg <= _CALM_TILT_DEG) & (force_g >= _CALM_G[0]) & (force_g <= _CALM_G[1])
    rest_s = _fell_to_rest(log, is_known, is_calm)
    if rest_s is not None:  # what moves it later is a hand
        is_known &= log.time_s <= rest_s + _BOUNCE_S
    time_s, is_calm = log.time_s[is_known], is_calm[is_known]
    if not len(time_s):
        return None, None
    loss_s, end_s = _last_calm_end(time_s, is_calm), float(time_s[-1])
    # Of the last peaks, the first.
    peaks_s = time_s[force_g[is_known] >= _IMPACT_G]
    firsts = np.flatnonzero(np.diff(peaks_s, prepend=-np.inf) > _BOUNCE_S)
    impact_s = float(peaks_s[firsts[-1]]) if len(firsts) else rest_s
    if impact_s is not None and loss_s > impact_s and end_s - loss_s >= _MIN_LOSS_S:
        impact_s = None  # it flew on after that peak
    if impact_s is not None:
        is_before = time_s <= impact_s
        loss_s, end_s = _last_calm_end(time_s[is_before], is_calm[is_before]), impact_s
    return loss_s if math.inf > end_s - loss_s >= _MIN_LOSS_S else None, impact_s


def _fell_to_rest(log: FlightLog, is_known: Flags, is_calm: Flags) -> float | None:
    """From when on it stayed at its last altitude, if it was not calm when it came there; None where unknown."""
    rows = np.flatnonzero(np.isfinite(log.altitude_m))
    away = np.flatnonzero(np.abs(log.altitude_m[rows] - log.altitude_m[rows[-1:]]) > _REST_M)
    if not len(away):
        return None
    rest_s = float(log.time_s[rows[away[-1]]])
    before = is_known & (log.time_s > rest_s - _CALM_S) & (log.time_s <= rest_s)
    return rest_s if before.any() and not is_calm[before].any() else None


def _last_calm_end(time_s: Floats, is_calm: Flags) -> float:
    """End of the last run of calm rows of at least `_CALM_S`; minus infinity without any."""
    firsts, lasts = runs(is_calm)
    ends_s = time_s[lasts]
    return float(ends_s[ends_s - time_s[firsts] >= _CALM_S].max(initial=-np.inf))


# Which thresholds?


class FlightGroup(Enum):
    """The side of a flight: what it is expected to do. The value is the text that is shown."""

    # Only a person knows whether it crashed, so a flight is on no side until one chooses.
    UNSORTED = marked("not sorted yet")
    MUST_NOT = marked("must not fire")
    MUST = marked("must fire")


# The map: its rows, and its columns, in the vendor's steps and in seconds.
TILTS_DEG: Final = np.arange(30, 121)
TIME_STEPS: Final = np.arange(20, MAX_TIME_STEPS + 1, 5)
TIMES_S: Final = TIME_STEPS / CENTISECOND.per_unit


def fire_map(
    must_not: Sequence[FlightSummary], must: Sequence[FlightSummary], limits: TriggerLimits
) -> tuple[Floats, Floats]:
    """Return, by attitude threshold (rows) and free-fall time (columns), the share of the flights that fire and must
    not, and of those that must and do not fire before the impact.

    Acceleration threshold and enabled triggers are those of `limits`; its other two values are not used. It takes
    milliseconds for a thousand flights. Raises LookupError for an acceleration above 1.5 g.
    """
    _, step, _ = steps_of(limits)

    def fired(flight: FlightSummary, until_s: float) -> Flags:
        tilts = limits.attitude_is_enabled & (flight.attitude_s[TILTS_DEG] <= until_s)
        falls: Flags = limits.freefall_is_enabled & (flight.freefall_s[step, TIME_STEPS] <= until_s)
        return tilts[:, None] | falls

    wrong, missed = (np.zeros((len(TILTS_DEG), len(TIME_STEPS))) for _ in range(2))
    for flight in must_not:
        wrong += fired(flight, EVER)
    for flight in must:
        missed += ~fired(flight, flight.end_s)
    return wrong / max(1, len(must_not)), missed / max(1, len(must))


# The proposal

# The bounds of a proposal are this program's. The vendor's table says less: 55° and up, below 0.7 g, and the defaults.
LEAST: Final = TriggerLimits(55, 0.3, SHORT_FALL_S)
MOST: Final = TriggerLimits(80, 0.6, 2.0)
# All thresholds, in the vendor's steps. What is computed for each of them has the shape (tilts, accelerations, times).
_TILTS, _ACCELERATIONS, _TIMES = np.ix_(
    *(np.arange(low, high + 1) for low, high in zip(steps_of(LEAST), steps_of(MOST), strict=True))
)
# Margins count up to 10° and 0.3 s; among equal proposals the one nearest to the vendor's defaults is chosen.
_FULL_TILT, _, _FULL_TIME = steps_of(TriggerLimits(10, 0, 0.3))


class FlightMargin(NamedTuple):
    """Distance of one flight from the thresholds of a proposal."""

    name: str
    # Must not fire: threshold minus largest tilt. Must fire: tilt reached in time minus threshold, negative where this
    # trigger alone would not fire. None where the log holds no attitude: then no margin is known.
    attitude_deg: int | None
    # The same with the longest fall and the free-fall time; None where the log holds no acceleration.
    freefall_s: float | None


class ThresholdProposal(NamedTuple):
    """`limits` is None where no thresholds separate the lists; `conflicts` then says why. It is None, too, where one
    side is empty."""

    limits: TriggerLimits | None
    # The flight with the smallest margin, of each side.
    nearest: Mapping[FlightGroup, FlightMargin]
    # The names of the flights of each side because of which nothing separates them.
    conflicts: Mapping[FlightGroup, Sequence[str]]


def propose(must_not: Sequence[FlightSummary], must: Sequence[FlightSummary]) -> ThresholdProposal:
    """Takes about 0.1 s for hundreds of flights."""
    if not must_not or not must:
        return ThresholdProposal(None, {}, {})
    sides = {
        group: [_Reached(flight, group) for flight in flights]
        for group, flights in ((FlightGroup.MUST_NOT, must_not), (FlightGroup.MUST, must))
    }
    margins = [one.margins for side in sides.values() for one in side]
    least = reduce(np.minimum, margins).clip(0, 1)
    tilt, acceleration, time = steps_of(TriggerLimits())
    off_defaults = (
        np.abs(_TILTS - tilt) / _FULL_TILT + np.abs(_ACCELERATIONS - acceleration) + np.abs(_TIMES - time) / _FULL_TIME
    )
    if least.max() <= 0:
        # Those that are wrong with the thresholds with which the fewest are.
        wrong = reduce(np.add, ((one <= 0).astype(np.int64) for one in margins))
        best = np.where(wrong == wrong.min(), off_defaults, np.inf).argmin()
        conflicts = {
            group: [one.flight.name for one in side if one.margins.flat[best] <= 0] for group, side in sides.items()
        }
        return ThresholdProposal(None, {}, conflicts)
    best = np.where(least == least.max(), off_defaults, np.inf).argmin()
    places = zip((_TILTS, _ACCELERATIONS, _TIMES), np.unravel_index(best, least.shape), strict=True)
    tilt, acceleration, time = (int(steps.flat[place]) for steps, place in places)
    nearest: dict[FlightGroup, FlightMargin] = {}
    for group, side in sides.items():
        one = min(side, key=lambda one: float(one.margins.flat[best]))
        sign = -1 if group is FlightGroup.MUST else 1
        fall_s = sign * (time - int(one.fall[acceleration])) / CENTISECOND.per_unit
        nearest[group] = FlightMargin(
            one.flight.name,
            None if math.isnan(one.flight.tilt_max_deg) else sign * (tilt - one.tilt),
            fall_s if one.flight.has_acceleration else None,
        )
    limits = TriggerLimits(tilt / DEGREE.per_unit, acceleration / TENTH_G.per_unit, time / CENTISECOND.per_unit)
    return ThresholdProposal(limits, nearest, {})


class _Reached:
    """The largest thresholds at which a flight fires in time, in the vendor's steps; -1: none."""

    def __init__(self, flight: FlightSummary, group: FlightGroup) -> None:
        self.flight = flight
        last_s = flight.end_s if group is FlightGroup.MUST else EVER
        self.tilt = int((flight.attitude_s <= last_s).sum()) - 1
        # The largest free-fall time, by acceleration threshold.
        self.fall: NDArray[np.int64] = (flight.freefall_s <= last_s).sum(axis=1) - 1
        tilts, times = (_TILTS - self.tilt) / _FULL_TILT, (_TIMES - self.fall[_ACCELERATIONS]) / _FULL_TIME
        # For all thresholds: 1 for a full margin, 0 and less where it is wrong.
        self.margins: Floats = np.minimum(tilts, times)
        if group is FlightGroup.MUST:
            # Either trigger is enough. One step more, since a flight that just reaches the threshold fires.
            self.margins = np.maximum(1 / _FULL_TILT - tilts, 1 / _FULL_TIME - times)


def defaults_result(flights: Sequence[FlightSummary], group: FlightGroup) -> tuple[list[str], list[str]]:
    """Judges the flights of one side with the vendor's defaults: those that fire and must not, or that must and do not
    fire in time; and those that do not fire, but hold too little to say so."""
    outcomes = [(flight.name, flight.outcome(TriggerLimits())) for flight in flights]
    if group is FlightGroup.MUST:
        unexpected = [name for name, outcome in outcomes if not outcome.is_before_impact]
    else:
        unexpected = [name for name, outcome in outcomes if outcome.answer is Answer.FIRES]
    not_judged = [name for name, outcome in outcomes if outcome.answer is Answer.NOT_JUDGED]
    return unexpected, not_judged
