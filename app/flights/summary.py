"""Summary of a flight for the map over thresholds, made once in a worker process: first firings, loss of control."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from app.flights.answer import Answer, Coverage, coverage_of
from app.flights.curves import NEVER, FiringCurves, firing_curves, steps_of
from app.flights.flight_log import Flags, FlightLog, Floats
from app.flights.judge import TriggerLimits
from app.flights.module_view import RuleReading
from app.flights.samples import runs
from app.text.durations import stopwatch
from app.text.i18n import tr
from app.text.messages import UserMessage
from protocol.catalogue import TENTH_G
from protocol.messages import Source

ALTITUDE_STEP_S: Final = 0.2


class FirstFire(NamedTuple):
    """First firing of a flight with given thresholds, under one reading."""

    at_s: float
    """Time of the `FlightLog`; infinite where it does not fire."""
    sources: Source
    is_in_time: bool
    """It fires before the impact."""
    delay_s: float
    """After the loss of control, negative before it; NaN where unknown."""
    drop_m: float
    """Loss of altitude since the loss of control; NaN where unknown."""

    @property
    def late_text(self) -> str:
        """How late it is, translated; empty where unknown."""
        if math.isnan(self.delay_s):
            return ""
        if self.delay_s < 0:  # it flew on: nothing tells that control was lost when it fired
            return tr("then calm again until {time}", time=moment_text(self.at_s - self.delay_s))
        late = tr("{delay:.2f} s after the loss of control", delay=self.delay_s)
        return late if math.isnan(self.drop_m) else tr("{late}, {drop:.0f} m lower", late=late, drop=self.drop_m)


def moment_text(at_s: float) -> str:
    """Time since the beginning of the log: "12.3 s", "3:07.2"."""
    return f"{at_s:.1f} s" if at_s < 60 else f"{stopwatch(at_s)}.{int(at_s * 10) % 10}"


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


class LossOfControl(NamedTuple):
    """Times of the `FlightLog`; None where unknown."""

    loss_s: float | None
    """End of the last calm second in flight before the impact: tilt up to 30°, 0.5 to 1.5 g. An estimate."""
    impact_s: float | None
    """First of the last peaks of 3 g or more, else the touchdown in the log."""


def loss_of_control(log: FlightLog) -> LossOfControl:
    """`loss_s` is None for a flight that was calm to its end or landing."""
    is_known = log.is_judged & np.isfinite(log.tilt_deg) & np.isfinite(log.specific_force_g)
    ended_s = _fell_to_rest(log, is_known)
    if ended_s is not None:  # what moves it later is a hand
        is_known &= log.time_s <= ended_s + BOUNCE_S
    time_s = log.time_s[is_known]
    if not len(time_s):
        return LossOfControl(None, None)
    tilt_deg, force_g = log.tilt_deg[is_known], log.specific_force_g[is_known]
    impact_s = _last_impact(time_s[force_g >= IMPACT_G])
    if impact_s is None:
        impact_s = _touchdown(log)
    if impact_s is None:
        impact_s = ended_s
    is_calm = _is_calm(tilt_deg, force_g)
    loss_s = _last_calm_end(time_s, is_calm)
    end_s = float(time_s[-1])
    if impact_s is not None and (loss_s is None or loss_s <= impact_s or end_s - loss_s < MIN_LOSS_S):
        before = time_s <= impact_s
        loss_s, end_s = _last_calm_end(time_s[before], is_calm[before]), impact_s
    else:  # it flew on after that peak
        impact_s = None
    if loss_s is not None and end_s - loss_s < MIN_LOSS_S:
        loss_s = None
    return LossOfControl(loss_s, impact_s)


def _is_calm(tilt_deg: Floats, force_g: Floats) -> Flags:
    calm: Flags = (tilt_deg <= CALM_TILT_DEG) & (force_g >= CALM_G[0]) & (force_g <= CALM_G[1])
    return calm


def _fell_to_rest(log: FlightLog, is_known: Flags) -> float | None:
    """From when on it stayed at its last altitude, if it was not calm when it came there; None where unknown."""
    if log.altitude_m is None:
        return None
    rows = np.flatnonzero(np.isfinite(log.altitude_m))
    away = np.flatnonzero(np.abs(log.altitude_m[rows] - log.altitude_m[rows[-1:]]) > REST_M)
    if not len(away):
        return None
    rest_s = float(log.time_s[rows[away[-1]]])
    before = is_known & (log.time_s > rest_s - CALM_S) & (log.time_s <= rest_s)
    if not before.any() or _is_calm(log.tilt_deg[before], log.specific_force_g[before]).any():
        return None
    return rest_s


def _last_impact(peaks_s: Floats) -> float | None:
    if not len(peaks_s):
        return None
    first = np.flatnonzero(np.diff(peaks_s, prepend=-np.inf) > BOUNCE_S)[-1]
    return float(peaks_s[first])


def _touchdown(log: FlightLog) -> float | None:
    if log.is_on_ground is None:
        return None
    touches = np.flatnonzero(log.is_on_ground[1:] & ~log.is_on_ground[:-1]) + 1
    return float(log.time_s[touches[-1]]) if len(touches) else None


def _last_calm_end(time_s: Floats, is_calm: Flags) -> float | None:
    """End of the last run of calm rows of at least `CALM_S`."""
    firsts, lasts = runs(is_calm)
    is_long = time_s[lasts] - time_s[firsts] >= CALM_S
    return float(time_s[lasts[is_long][-1]]) if is_long.any() else None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightSummary:
    """One flight; times are those of its `FlightLog`, which is read again to show it."""

    name: str
    """Path of the file as given."""
    duration_s: float
    not_judged_s: float
    tilt_max_deg: float
    """As measured, of the judged rows; NaN without any."""
    has_attitude: bool
    """The log holds an attitude while it is judged."""
    has_acceleration: bool
    coverage: Coverage
    curves: Mapping[RuleReading, FiringCurves]
    loss_s: float | None
    """Estimated loss of control; None: not lost, or unknown."""
    impact_s: float | None
    """None: unknown."""
    altitude_time_s: Floats
    """Ascending, about 0.2 s apart; empty where the log has none."""
    altitude_m: Floats
    problems: tuple[UserMessage, ...]

    def altitude_at(self, time_s: float) -> float:
        """Altitude in metres; NaN where unknown."""
        times = self.altitude_time_s
        if not len(times) or not times[0] <= time_s <= times[-1] + ALTITUDE_STEP_S:
            return math.nan
        return float(np.interp(time_s, times, self.altitude_m))

    def first_fire(self, limits: TriggerLimits, reading: RuleReading = RuleReading.DIRECT) -> FirstFire:
        """Raises LookupError for a free-fall acceleration above 1.5 g."""
        at_s, sources = self.curves[reading].first(limits)
        fires = at_s != NEVER
        if not fires or self.loss_s is None:
            return FirstFire(at_s, sources, fires and at_s <= self.end_s, math.nan, math.nan)
        drop_m = self.altitude_at(self.loss_s) - self.altitude_at(at_s)
        return FirstFire(at_s, sources, at_s <= self.end_s, at_s - self.loss_s, drop_m)

    def answer(self, limits: TriggerLimits) -> Answer:
        """Would it have fired? Raises LookupError for a free-fall acceleration above 1.5 g."""
        if self.first_fire(limits).sources:
            return Answer.FIRES
        return Answer.DOES_NOT_FIRE if self.coverage.is_enough(limits) else Answer.NOT_JUDGED

    def longest_fall_s(self, limits: TriggerLimits) -> float:
        """From first to last report below their acceleration, unfiltered; -1 without any. Raises LookupError."""
        step = steps_of(limits.freefall_acceleration_g, TENTH_G.per_unit)
        return float(self.curves[RuleReading.DIRECT].longest_fall_s[step])

    @property
    def end_s(self) -> float:
        """Time after which firing is too late: the impact, infinite where unknown."""
        return NEVER if self.impact_s is None else self.impact_s


def summarise(log: FlightLog) -> FlightSummary:
    """Takes about 15 ms for a flight of ten minutes."""
    lost = loss_of_control(log)
    tilts = log.tilt_deg[log.is_judged & np.isfinite(log.tilt_deg)]
    altitude_time_s, altitude_m = _altitude(log)
    return FlightSummary(
        name=log.name,
        duration_s=log.duration_s,
        not_judged_s=log.not_judged_s,
        tilt_max_deg=float(tilts.max()) if len(tilts) else math.nan,
        has_attitude=len(tilts) > 0,
        has_acceleration=bool((log.is_judged & np.isfinite(log.specific_force_g)).any()),
        coverage=coverage_of(log),
        curves={reading: firing_curves(log, reading) for reading in RuleReading},
        loss_s=lost.loss_s,
        impact_s=lost.impact_s,
        altitude_time_s=altitude_time_s,
        altitude_m=altitude_m,
        problems=log.problems,
    )


def _altitude(log: FlightLog) -> tuple[Floats, Floats]:
    """The first row of each step of `ALTITUDE_STEP_S`."""
    if log.altitude_m is None:
        return np.empty(0), np.empty(0)
    rows = np.flatnonzero(np.isfinite(log.altitude_m))
    numbers = np.floor(log.time_s[rows] / ALTITUDE_STEP_S)
    rows = rows[np.diff(numbers, prepend=-1.0) != 0]
    return log.time_s[rows], log.altitude_m[rows]
