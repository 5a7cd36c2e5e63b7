"""Summary of a flight, made once in a worker process: its first firings, and when it was lost."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from app.flights.flight_log import FlightLog, runs
from app.flights.judge import TriggerLimits
from app.flights.judging import (
    EVER,
    Answer,
    Coverage,
    FiringCurves,
    RuleReading,
    acceleration_step,
    coverage_of,
    firing_curves,
)
from app.flights.raw_log import Flags, Floats
from app.text.durations import stopwatch
from app.text.i18n import tr
from app.text.messages import UserMessage
from protocol.messages import Source

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
