"""Judges where a flight would have fired with given thresholds, under either reading of the vendor's rule."""

from typing import NamedTuple

import numpy as np

from app.firing.judge import TriggerLimits
from app.firing.samples import judge_samples
from app.flight_logs.flight_log import FlightLog
from app.flight_logs.module_view import RuleReading, attitude_view, freefall_view, to_steps
from protocol.catalogue import DEGREE, TENTH_G
from protocol.messages import Source


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
