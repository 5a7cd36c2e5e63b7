"""Where a flight would have fired, under either reading of the vendor's rule: with given thresholds, or first for every
threshold in the vendor's steps, computed once, after which thresholds are a look-up."""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from app.flights.flight_log import FlightLog, Floats
from app.flights.judge import MAX_GAP_S, ROUNDING_S, TriggerLimits
from app.flights.module_view import RuleReading, attitude_view, freefall_view, to_steps
from app.flights.samples import Samples, firing_places, judge_samples, runs
from protocol.catalogue import CENTISECOND, DEGREE, TENTH_G
from protocol.messages import Source

MAX_TILT_STEPS: Final = 180
"""Whole degrees; the largest possible tilt."""
MAX_ACCELERATION_STEPS: Final = 15
"""Tenths of g; above 1.5 g everything would be a fall."""
MAX_TIME_STEPS: Final = 255
"""Hundredths of a second: the byte's largest."""
NEVER: Final = math.inf


@dataclass(frozen=True, slots=True, eq=False)
class FiringCurves:
    """Of one flight under one reading. Times are seconds of the `FlightLog`, `NEVER` where nothing fires."""

    attitude_s: Floats
    """Shape (181,): first firing of the attitude trigger, by threshold in whole degrees."""
    freefall_s: Floats
    """Shape (16, 256): first firing of the free-fall trigger, by threshold in tenths of g and time in hundredths of
    a second."""
    longest_fall_s: Floats
    """Shape (16,): longest fall from first to last report, by threshold in tenths of g; -1 where there is none."""

    def first(self, limits: TriggerLimits) -> tuple[float, Source]:
        """When it fires first, and why; `NEVER` and nothing where it does not.

        Raises LookupError for a free-fall acceleration above 1.5 g.
        """
        attitude_s = freefall_s = NEVER
        if limits.attitude_is_enabled:
            tilt_step = steps_of(limits.attitude_threshold_deg, DEGREE.per_unit)
            attitude_s = float(self.attitude_s[tilt_step]) if tilt_step <= MAX_TILT_STEPS else NEVER
        if limits.freefall_is_enabled:
            acceleration_step = steps_of(limits.freefall_acceleration_g, TENTH_G.per_unit)
            if acceleration_step > MAX_ACCELERATION_STEPS:
                raise LookupError(limits.freefall_acceleration_g)
            freefall_s = float(
                self.freefall_s[acceleration_step, steps_of(limits.freefall_time_s, CENTISECOND.per_unit)]
            )
        at_s = min(attitude_s, freefall_s)
        if at_s == NEVER:
            return NEVER, Source(0)
        sources = Source.ATTITUDE if attitude_s == at_s else Source(0)
        return at_s, sources | (Source.FREEFALL if freefall_s == at_s else Source(0))


def steps_of(value: float, per_unit: int) -> int:
    return round(value * per_unit)


def firing_curves(log: FlightLog, reading: RuleReading) -> FiringCurves:
    """Takes about 10 ms for a flight of ten minutes."""
    tilts = attitude_view(log, reading)
    attitude_s = _attitude_curve(tilts.time_s[tilts.is_active], tilts.values[tilts.is_active])
    return FiringCurves(attitude_s, *_freefall_curves(freefall_view(log, reading), log.resets_s))


def _attitude_curve(time_s: Floats, tilt_deg: Floats) -> Floats:
    curve = np.full(MAX_TILT_STEPS + 1, NEVER)
    if len(time_s):
        highest = np.maximum.accumulate(tilt_deg)
        rows = np.searchsorted(highest, np.arange(MAX_TILT_STEPS + 1), "left")
        is_reached = rows < len(time_s)
        curve[is_reached] = time_s[rows[is_reached]]
    return curve


def _freefall_curves(samples: Samples, resets_s: tuple[float, ...]) -> tuple[Floats, Floats]:
    firsts_s = np.full((MAX_ACCELERATION_STEPS + 1, MAX_TIME_STEPS + 1), NEVER)
    longest_s = np.full(MAX_ACCELERATION_STEPS + 1, -1.0)
    time_s = samples.time_s
    steps = np.rint(samples.values * TENTH_G.per_unit).astype(np.int64)
    steps[~samples.is_active] = MAX_ACCELERATION_STEPS + 1
    restarts = np.diff(time_s, prepend=-np.inf) > MAX_GAP_S
    resets = np.searchsorted(time_s, resets_s, "left")
    restarts[resets[resets < len(time_s)]] = True
    times_s = np.arange(MAX_TIME_STEPS + 1) / CENTISECOND.per_unit
    for step in range(1, MAX_ACCELERATION_STEPS + 1):
        is_below = steps < step
        if not is_below.any():
            continue
        firsts, lasts = runs(is_below, restarts)
        lasted_s = time_s[lasts] - time_s[firsts]
        longest_s[step] = lasted_s.max()
        fall = np.searchsorted(np.maximum.accumulate(lasted_s), times_s - ROUNDING_S, "left")
        count = int((fall < len(firsts)).sum())
        since = firsts[fall[:count]]
        rows = firing_places(time_s, times_s[:count], since, time_s[since])
        firsts_s[step, :count] = time_s[rows]
    return firsts_s, longest_s


class LogFiring(NamedTuple):
    """A row at which the module would have fired; NaN where the log has no value."""

    at_s: float
    """Time of the `FlightLog`."""
    sources: Source
    tilt_deg: float
    """Whole degrees, as a module reports it."""
    acceleration_g: float
    """Tenths of g, as a module reports it."""


class JudgedFlight(NamedTuple):
    """One flight, one set of thresholds, one reading. Times are those of the `FlightLog`."""

    limits: TriggerLimits
    reading: RuleReading
    firings: tuple[LogFiring, ...]
    """In order of time, the first 500 of each trigger."""
    longest_miss_s: float
    """Of the falls that were too short; 0 without any."""


def judge_flight(log: FlightLog, limits: TriggerLimits, reading: RuleReading = RuleReading.DIRECT) -> JudgedFlight:
    """Uses the rules of the simulated module.

    Each trigger is judged on the rows in which its quantity is known.
    """
    found = judge_samples(attitude_view(log, reading), freefall_view(log, reading), limits, log.resets_s)
    firings = tuple(_firing(log, at_s, sources) for at_s, sources in found.firings)
    return JudgedFlight(limits, reading, firings, found.longest_miss_s)


def _firing(log: FlightLog, at_s: float, sources: Source) -> LogFiring:
    row = int(np.searchsorted(log.time_s, at_s, "left"))
    tilt, force = log.tilt_deg[row : row + 1], log.specific_force_g[row : row + 1]
    return LogFiring(
        at_s,
        sources,
        float(to_steps(tilt, DEGREE.per_unit)[0]),
        float(to_steps(force, TENTH_G.per_unit)[0]),
    )
