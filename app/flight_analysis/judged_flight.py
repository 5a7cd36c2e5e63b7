"""Judges where a flight would have fired with given thresholds, under either reading of the vendor's rule."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from app.firing.judge import TriggerLimits
from app.firing.near_misses import NearFall, NearTilt
from app.firing.points import Stretch
from app.firing.would_fire import WhatIfAnalysis, WhatIfFinding
from app.flight_logs.flight_log import Flags, FlightLog
from app.flight_logs.module_view import RuleReading, attitude_view, freefall_view, to_steps
from app.recordings.excerpt import Excerpt
from app.recordings.markers import Marker, MarkerKind
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
    altitude_m: float


@dataclass(frozen=True, slots=True)
class JudgedFlight:
    """One flight, one set of thresholds, one reading. Times are those of the `FlightLog`."""

    limits: TriggerLimits
    reading: RuleReading
    firings: tuple[LogFiring, ...]
    """In order of time, the first 500 of each trigger."""
    firing_count: int
    """All, including those that are not listed."""
    near_tilts: tuple[NearTilt, ...]
    """Angles near the threshold, the nearest first."""
    near_falls: tuple[NearFall, ...]
    """Falls that were too short, the longest first."""


def judge_flight(log: FlightLog, limits: TriggerLimits, reading: RuleReading = RuleReading.DIRECT) -> JudgedFlight:
    """Uses the judge of live sessions and of the simulated module.

    Each trigger is judged on the rows in which its quantity is known.
    """
    tilt = _finding(log, *attitude_view(log, reading), replace(limits, freefall_is_enabled=False))
    fall = _finding(log, *freefall_view(log, reading), replace(limits, attitude_is_enabled=False))
    sources: dict[float, Source] = {}
    for one in (*tilt.firings, *fall.firings):
        sources[one.sample.at_s] = sources.get(one.sample.at_s, Source(0)) | one.sources
    return JudgedFlight(
        limits,
        reading,
        tuple(_firing(log, at_s, sources[at_s]) for at_s in sorted(sources)),
        len(sources) + sum(found.firing_count - len(found.firings) for found in (tilt, fall)),
        tilt.near_tilts,
        fall.near_falls,
    )


def _finding(log: FlightLog, stretch: Stretch, is_judged: Flags, limits: TriggerLimits) -> WhatIfFinding:
    no_times, no_values = np.empty(0), np.empty(0, np.float32)
    analysis = WhatIfAnalysis(limits, counts_locked=False)
    analysis.feed(
        Excerpt(
            start_s=0.0,
            end_s=log.duration_s,
            time_s=stretch.time_s,
            tilt_deg=stretch.tilt_deg.astype(np.float32),
            acceleration_g=stretch.acceleration_g.astype(np.float32),
            is_triggered=np.zeros(len(stretch.time_s), np.bool_),
            is_active=is_judged,
            cell_time_s=no_times,
            cell_voltage_v=no_values,
            light_time_s=no_times,
            light_v=no_values,
            markers=tuple(Marker(at_s, MarkerKind.RESTARTED) for at_s in log.resets_s),
        )
    )
    return analysis.finding


def _firing(log: FlightLog, at_s: float, sources: Source) -> LogFiring:
    row = int(np.searchsorted(log.time_s, at_s, "left"))
    tilt, force = log.tilt_deg[row : row + 1], log.specific_force_g[row : row + 1]
    altitude_m = float("nan") if log.altitude_m is None else float(log.altitude_m[row])
    return LogFiring(
        at_s,
        sources,
        float(to_steps(tilt, DEGREE.per_unit)[0]),
        float(to_steps(force, TENTH_G.per_unit)[0]),
        altitude_m,
    )
