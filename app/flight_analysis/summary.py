"""Summary of a flight for the map over thresholds: small, made once in a worker process."""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from app.firing.judge import TriggerLimits
from app.flight_analysis.curves import NEVER, FiringCurves, firing_curves
from app.flight_analysis.loss_of_control import loss_of_control
from app.flight_logs.flight_log import FlightLog, Floats, LogFormat
from app.flight_logs.module_view import RuleReading
from app.text.durations import stopwatch
from app.text.i18n import tr
from app.text.messages import UserMessage
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightSummary:
    """One flight; times are those of its `FlightLog`, which is read again to show it."""

    name: str
    """Path of the file as given."""
    format: LogFormat
    duration_s: float
    not_judged_s: float
    tilt_max_deg: float
    """As measured, of the judged rows; NaN without any."""
    direct: FiringCurves
    damped: FiringCurves
    loss_s: float | None
    """Estimated loss of control; None: not lost, or unknown."""
    impact_s: float | None
    """None: unknown."""
    altitude_time_s: Floats
    """Ascending, about 0.2 s apart; empty where the log has none."""
    altitude_m: Floats
    problems: tuple[UserMessage, ...]

    def curves(self, reading: RuleReading) -> FiringCurves:
        return self.direct if reading is RuleReading.DIRECT else self.damped

    def altitude_at(self, time_s: float) -> float:
        """Altitude in metres; NaN where unknown."""
        times = self.altitude_time_s
        if not len(times) or not times[0] <= time_s <= times[-1] + ALTITUDE_STEP_S:
            return math.nan
        return float(np.interp(time_s, times, self.altitude_m))

    def first_fire(self, limits: TriggerLimits, reading: RuleReading = RuleReading.DIRECT) -> FirstFire:
        """Raises LookupError for a free-fall acceleration above 1.5 g."""
        at_s, sources = self.curves(reading).first(limits)
        fires = at_s != NEVER
        if not fires or self.loss_s is None:
            return FirstFire(at_s, sources, fires and at_s <= self.end_s, math.nan, math.nan)
        drop_m = self.altitude_at(self.loss_s) - self.altitude_at(at_s)
        return FirstFire(at_s, sources, at_s <= self.end_s, at_s - self.loss_s, drop_m)

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
        format=log.format,
        duration_s=log.duration_s,
        not_judged_s=log.not_judged_s,
        tilt_max_deg=float(tilts.max()) if len(tilts) else math.nan,
        direct=firing_curves(log, RuleReading.DIRECT),
        damped=firing_curves(log, RuleReading.DAMPED),
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
