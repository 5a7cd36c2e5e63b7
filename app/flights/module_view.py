"""A flight at the module's resolution, under both readings of what the vendor's table leaves open."""

from enum import Enum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.flights.flight_log import FlightLog, Floats
from app.flights.judge import MAX_GAP_S, ROUNDING_S
from app.flights.samples import Samples
from protocol.catalogue import DEGREE, TENTH_G
from protocol.translatable import marked

DAMPING_S: Final = 0.2
"""Damped reading: how long the angle must last, and the averaging time of the acceleration."""


class RuleReading(Enum):
    """Interpretation of what the vendor's rule leaves open; the value describes it."""

    DIRECT = marked("angle at once, acceleration unfiltered")
    """As `app.flights.judge.Judge` and the simulated module do."""
    DAMPED = marked("angle lasts 0.2 s, acceleration averaged over 0.2 s")


def attitude_view(log: FlightLog, reading: RuleReading) -> Samples:
    """The rows with a known attitude at the module's resolution.

    Rows that are not judged count as those of a locked module, which resets its state.
    """
    rows = np.isfinite(log.tilt_deg)
    time_s, tilt_deg = log.time_s[rows], log.tilt_deg[rows]
    if reading is RuleReading.DAMPED:
        tilt_deg = lasting(time_s, tilt_deg)
        is_known = np.isfinite(tilt_deg)
        time_s, tilt_deg, rows = time_s[is_known], tilt_deg[is_known], np.flatnonzero(rows)[is_known]
    return Samples(time_s, to_steps(tilt_deg, DEGREE.per_unit), log.is_judged[rows])


def freefall_view(log: FlightLog, reading: RuleReading) -> Samples:
    """Like `attitude_view`: the rows with a known acceleration."""
    rows = np.isfinite(log.specific_force_g)
    time_s, force_g = log.time_s[rows], log.specific_force_g[rows]
    if reading is RuleReading.DAMPED:
        force_g = averaged(time_s, force_g)
    return Samples(time_s, to_steps(force_g, TENTH_G.per_unit), log.is_judged[rows])


def to_steps(values: Floats, per_unit: int) -> Floats:
    """Rounds to the steps that the module reports in a byte."""
    steps: Floats = np.clip(np.rint(values * per_unit), 0, 255) / per_unit
    return steps


def _window_starts(time_s: Floats, over_s: float) -> NDArray[np.intp]:
    """For each row the first row of the last `over_s` since a pause."""
    starts = np.searchsorted(time_s, time_s - (over_s + ROUNDING_S), "left")
    return np.maximum(starts, _stretch_starts(time_s))


def lasting(time_s: Floats, tilt_deg: Floats) -> Floats:
    """Minimum of the last `DAMPING_S`; NaN until that much time has passed since a pause."""
    if not len(time_s):
        return tilt_deg
    bounds = np.stack((_window_starts(time_s, DAMPING_S), np.arange(1, len(time_s) + 1)), axis=1).ravel()
    minima: Floats = np.minimum.reduceat(np.append(tilt_deg, np.inf), bounds)[::2]  # of each pair of bounds
    minima[time_s - time_s[_stretch_starts(time_s)] < DAMPING_S - ROUNDING_S] = np.nan
    return minima


def averaged(time_s: Floats, values: Floats, over_s: float = DAMPING_S) -> Floats:
    """Mean of the last `over_s`, both ends included, since a pause."""
    if not len(time_s):
        return values
    sums = np.concatenate(((0.0,), np.cumsum(values)))
    starts = _window_starts(time_s, over_s)
    stops = np.arange(1, len(values) + 1)
    mean: Floats = (sums[stops] - sums[starts]) / (stops - starts)
    return mean


def _stretch_starts(time_s: Floats) -> NDArray[np.intp]:
    """For each row the first row after the last pause."""
    is_first = np.diff(time_s, prepend=-np.inf) > MAX_GAP_S
    starts: NDArray[np.intp] = np.maximum.accumulate(np.where(is_first, np.arange(len(time_s)), 0))
    return starts
