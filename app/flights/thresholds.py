"""Which thresholds? The map over them, and a proposal that separates flights that must fire from those that must not.

A proposal can kill, so it stays within the narrow bounds of this program. Under both readings of the vendor's rule no
flight fires that must not, and each fires before the impact that must. Flights of one side alone propose nothing: they
only tell what the vendor's defaults do in them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import reduce
from types import MappingProxyType
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from app.flights.judge import TriggerLimits
from app.flights.judging import (
    EVER,
    MAX_TIME_STEPS,
    Answer,
    FirstFire,
    FlightSummary,
    RuleReading,
    acceleration_step,
    steps_of,
)
from app.flights.raw_log import Floats
from app.safety.consequences import SHORT_FALL_S
from app.text.messages import UserMessage
from protocol.catalogue import CENTISECOND, DEGREE, TENTH_G
from protocol.fields import Value
from protocol.translatable import marked

Steps = NDArray[np.int64]


class FlightGroup(Enum):
    """What a flight is expected to do; the value is the text that is shown."""

    # Only a person knows whether it crashed, so a flight is on no side until one chooses.
    UNSORTED = marked("not sorted yet")
    MUST_NOT = marked("must not fire")
    MUST = marked("must fire")


class FlightOutcome(NamedTuple):
    """First firings of one flight with given thresholds, under both readings."""

    flight: FlightSummary
    group: FlightGroup
    direct: FirstFire
    damped: FirstFire
    answer: Answer
    why_not_judged: UserMessage | None

    @property
    def is_different(self) -> bool:
        """The readings of the vendor's rule disagree on whether it fires, or fires in time."""
        if bool(self.direct.sources) != bool(self.damped.sources):
            return True
        return self.direct.is_in_time != self.damped.is_in_time


def outcome_of(flight: FlightSummary, group: FlightGroup, limits: TriggerLimits) -> FlightOutcome:
    """Raises LookupError for an acceleration above 1.5 g."""
    direct, damped = (flight.first_fire(limits, reading) for reading in RuleReading)
    why_not = flight.coverage.why_not_enough(limits)
    return FlightOutcome(flight, group, direct, damped, flight.answer(limits), why_not)


def settings_of(limits: TriggerLimits) -> dict[str, Value]:
    """Thresholds by the names of profiles and `dps-s set`, in the vendor's steps."""
    return {
        "attitude_threshold_deg": round(limits.attitude_threshold_deg),
        "freefall_acceleration_g": round(limits.freefall_acceleration_g, 1),
        "freefall_time_s": round(limits.freefall_time_s, 2),
    }


# The map

TILTS_DEG: Final = np.arange(30, 121)
"""Its rows."""
TIME_STEPS: Final = np.arange(20, MAX_TIME_STEPS + 1, 5)
"""Its columns, in the vendor's steps."""
TIMES_S: Final = TIME_STEPS / CENTISECOND.per_unit


@dataclass(frozen=True, slots=True, eq=False)
class FireMap:
    """Number of flights that fire, by attitude threshold (rows) and free-fall time (columns)."""

    must_not_count: int
    must_count: int
    # False triggers.
    must_not_fired: Steps
    # Fired before the impact.
    must_fired: Steps


def fire_map(
    must_not: Sequence[FlightSummary], must: Sequence[FlightSummary], limits: TriggerLimits, reading: RuleReading
) -> FireMap:
    """Acceleration threshold and enabled triggers are those of `limits`; its other two values are not used.

    Takes milliseconds for a thousand flights. Raises LookupError for an acceleration above 1.5 g.
    """
    step = acceleration_step(limits)

    def count(flights: Sequence[FlightSummary], *, is_in_time: bool) -> Steps:
        fired = np.zeros((len(TILTS_DEG), len(TIME_STEPS)), np.int64)
        for flight in flights:
            curves = flight.curves[reading]
            until_s = flight.end_s if is_in_time else EVER
            tilts = limits.attitude_is_enabled & (curves.attitude_s[TILTS_DEG] <= until_s)
            falls = limits.freefall_is_enabled & (curves.freefall_s[step, TIME_STEPS] <= until_s)
            fired += tilts[:, None] | falls
        return fired

    return FireMap(len(must_not), len(must), count(must_not, is_in_time=False), count(must, is_in_time=True))


# The proposal

FULL_MARGIN_DEG: Final = 10
FULL_MARGIN_S: Final = 0.3
"""Margins count up to these; among equal proposals the one nearest to the vendor's defaults is chosen."""
# The bounds of a proposal are this program's. The vendor's table says less: 55° and up, below 0.7 g, and the defaults.
LEAST_TILT_DEG: Final = 55
MOST_TILT_DEG: Final = 80
LEAST_ACCELERATION_G: Final = 0.3
MOST_ACCELERATION_G: Final = 0.6
LEAST_FALL_S: Final = SHORT_FALL_S
MOST_FALL_S: Final = 2.0


def _steps_between(low: float, high: float, per_unit: int) -> Steps:
    return np.arange(steps_of(low, per_unit), steps_of(high, per_unit) + 1)


# All thresholds, in the vendor's steps. What is computed for each of them has the shape (tilts, accelerations, times).
TILTS: Final = _steps_between(LEAST_TILT_DEG, MOST_TILT_DEG, DEGREE.per_unit)[:, None, None]
ACCELERATIONS: Final = _steps_between(LEAST_ACCELERATION_G, MOST_ACCELERATION_G, TENTH_G.per_unit)[:, None]
TIMES: Final = _steps_between(LEAST_FALL_S, MOST_FALL_S, CENTISECOND.per_unit)
FULL_TILT: Final = FULL_MARGIN_DEG * DEGREE.per_unit
FULL_TIME: Final = round(FULL_MARGIN_S * CENTISECOND.per_unit)


class FlightMargin(NamedTuple):
    """Distance of one flight from the thresholds of a proposal."""

    name: str
    group: FlightGroup
    # Must not fire: threshold minus largest tilt. Must fire: tilt reached in time minus threshold, negative where this
    # trigger alone would not fire. None where the log holds no attitude: then no margin is known.
    attitude_deg: int | None
    # The same with the longest fall and the free-fall time; None where the log holds no acceleration.
    freefall_s: float | None


class DefaultsResult(NamedTuple):
    """What the vendor's defaults do in the flights of one side, while the other side is empty."""

    group: FlightGroup
    total: int
    # The flights that fire and must not, or that must and do not fire in time under each reading.
    unexpected: tuple[str, ...]
    # The flights that do not fire, but hold too little to say so.
    not_judged: tuple[str, ...]


class ThresholdProposal(NamedTuple):
    """`limits` is None where no thresholds separate the lists; `conflicts` then says why.

    It is None, too, where one side is empty; `defaults` then says what the vendor's defaults do.
    """

    limits: TriggerLimits | None
    # The flight with the smallest margin, of each side.
    nearest: Mapping[FlightGroup, FlightMargin] = MappingProxyType({})
    # The names of the flights of each side because of which nothing separates them.
    conflicts: Mapping[FlightGroup, Sequence[str]] = MappingProxyType({})
    defaults: DefaultsResult | None = None


def propose(must_not: Sequence[FlightSummary], must: Sequence[FlightSummary]) -> ThresholdProposal:
    """Takes about 0.1 s for hundreds of flights."""
    if not must_not or not must:
        group = FlightGroup.MUST if must else FlightGroup.MUST_NOT
        return ThresholdProposal(None, defaults=defaults_result(must or must_not, group))
    calm = [_Reached.of(flight, FlightGroup.MUST_NOT) for flight in must_not]
    lost = [_Reached.of(flight, FlightGroup.MUST) for flight in must]
    least = reduce(np.minimum, (one.margins().clip(0, 1) for one in (*calm, *lost)))
    usual = TriggerLimits()
    off_defaults = (
        np.abs(TILTS - steps_of(usual.attitude_threshold_deg, DEGREE.per_unit)) / FULL_TILT
        + np.abs(ACCELERATIONS - steps_of(usual.freefall_acceleration_g, TENTH_G.per_unit))
        + np.abs(TIMES - steps_of(usual.freefall_time_s, CENTISECOND.per_unit)) / FULL_TIME
    )
    if least.max() <= 0:
        # Those that are wrong with the thresholds with which the fewest are.
        wrong = reduce(np.add, ((one.margins() <= 0).astype(np.int64) for one in (*calm, *lost)))
        best = np.where(wrong == wrong.min(), off_defaults, np.inf).argmin()
        sides = {FlightGroup.MUST_NOT: calm, FlightGroup.MUST: lost}
        conflicts = {
            group: [one.flight.name for one in side if one.margins().flat[best] <= 0] for group, side in sides.items()
        }
        return ThresholdProposal(None, conflicts=conflicts)
    best = np.where(least == least.max(), off_defaults, np.inf).argmin()
    limits = _limits_at(best)
    nearest = [min(side, key=lambda one: float(one.margins().flat[best])) for side in (calm, lost)]
    return ThresholdProposal(limits, {one.group: one.margin(limits) for one in nearest})


def defaults_result(flights: Sequence[FlightSummary], group: FlightGroup) -> DefaultsResult:
    """Judges the flights of one side with the vendor's defaults, under both readings."""
    unexpected: list[str] = []
    not_judged: list[str] = []
    for flight in flights:
        fires = [flight.first_fire(TriggerLimits(), reading) for reading in RuleReading]
        if group is FlightGroup.MUST:
            is_expected = all(fire.is_in_time for fire in fires)
        else:
            is_expected = not any(fire.sources for fire in fires)
        if not is_expected:
            unexpected.append(flight.name)
        if flight.answer(TriggerLimits()) is Answer.NOT_JUDGED:
            not_judged.append(flight.name)
    return DefaultsResult(group, len(flights), tuple(unexpected), tuple(not_judged))


def _limits_at(place: np.intp) -> TriggerLimits:
    """`place`: in the flattened array of all thresholds."""
    tilt, acceleration, time = np.unravel_index(place, (TILTS.size, ACCELERATIONS.size, TIMES.size))
    return TriggerLimits(
        attitude_threshold_deg=int(TILTS.flat[tilt]) / DEGREE.per_unit,
        freefall_acceleration_g=int(ACCELERATIONS.flat[acceleration]) / TENTH_G.per_unit,
        freefall_time_s=int(TIMES[time]) / CENTISECOND.per_unit,
    )


class _Reached(NamedTuple):
    """The largest thresholds at which a flight fires, in the vendor's steps; -1: none.

    The worse reading counts: the larger value for a flight that must not fire, the smaller one for one that must.
    """

    flight: FlightSummary
    group: FlightGroup
    tilt: int
    # The largest free-fall time, by acceleration threshold.
    fall: Steps

    @classmethod
    def of(cls, flight: FlightSummary, group: FlightGroup) -> "_Reached":
        worse = np.min if group is FlightGroup.MUST else np.max
        last_s = flight.end_s if group is FlightGroup.MUST else EVER
        curves = flight.curves.values()
        tilt = worse([(curve.attitude_s <= last_s).sum() - 1 for curve in curves])
        fall = worse([(curve.freefall_s <= last_s).sum(axis=1) - 1 for curve in curves], axis=0)
        return cls(flight, group, int(tilt), fall)

    def margins(self) -> Floats:
        """For all thresholds, 1 for a full margin, 0 and less where it is wrong."""
        tilts = (TILTS - self.tilt) / FULL_TILT
        times = (TIMES - self.fall[ACCELERATIONS]) / FULL_TIME
        if self.group is FlightGroup.MUST_NOT:
            return np.minimum(tilts, times)
        # Either trigger is enough. One step more, since a flight that just reaches the threshold fires.
        return np.maximum(1 / FULL_TILT - tilts, 1 / FULL_TIME - times)

    def margin(self, limits: TriggerLimits) -> FlightMargin:
        tilt_deg = round(limits.attitude_threshold_deg) - self.tilt
        fall_s = limits.freefall_time_s - int(self.fall[acceleration_step(limits)]) / CENTISECOND.per_unit
        if self.group is FlightGroup.MUST:
            tilt_deg = -tilt_deg
            fall_s = -fall_s
        return FlightMargin(
            self.flight.name,
            self.group,
            tilt_deg if self.flight.has_attitude else None,
            fall_s if self.flight.has_acceleration else None,
        )
