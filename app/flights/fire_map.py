"""Flights that must and must not fire, and the map over thresholds."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from app.flights.answer import Answer
from app.flights.curves import MAX_ACCELERATION_STEPS, MAX_TIME_STEPS, steps_of
from app.flights.judge import TriggerLimits
from app.flights.module_view import RuleReading
from app.flights.summary import FirstFire, FlightSummary
from app.text.messages import UserMessage
from protocol.catalogue import CENTISECOND, TENTH_G
from protocol.translatable import marked

Counts = NDArray[np.int64]
TILTS_DEG: Final = np.arange(30, 121)
"""The rows of the map."""
TIME_STEPS: Final = np.arange(20, MAX_TIME_STEPS + 1, 5)
"""Its columns, in the vendor's steps."""
TIMES_S: Final = TIME_STEPS / CENTISECOND.per_unit


class FlightGroup(Enum):
    """What a flight is expected to do; the value is the text that is shown."""

    UNSORTED = marked("not sorted yet")
    """Only a person knows whether it crashed, so a flight is on no side until one chooses."""
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
        direct, damped = ((bool(fire.sources), fire.is_in_time) for fire in (self.direct, self.damped))
        return direct != damped


def outcome_of(flight: FlightSummary, group: FlightGroup, limits: TriggerLimits) -> FlightOutcome:
    """Raises LookupError for an acceleration above 1.5 g."""
    direct, damped = (flight.first_fire(limits, reading) for reading in RuleReading)
    why_not = flight.coverage.why_not_enough(limits)
    return FlightOutcome(flight, group, direct, damped, flight.answer(limits), why_not)


@dataclass(frozen=True, slots=True, eq=False)
class FireMap:
    """Number of flights that fire, by attitude threshold (rows) and free-fall time (columns)."""

    must_not_count: int
    must_count: int
    must_not_fired: Counts
    """False triggers."""
    must_fired: Counts
    """Fired before the impact."""


def fire_map(
    must_not: Sequence[FlightSummary], must: Sequence[FlightSummary], limits: TriggerLimits, reading: RuleReading
) -> FireMap:
    """Acceleration threshold and enabled triggers are those of `limits`; its other two values are not used.

    Takes milliseconds for a thousand flights. Raises LookupError for an acceleration above 1.5 g.
    """
    # Finite: what never fires has the time infinity, which is not before an impact that is unknown.
    last_s = float(np.finfo(np.float64).max)
    return FireMap(
        len(must_not),
        len(must),
        _fired(((flight, last_s) for flight in must_not), limits, reading),
        _fired(((flight, min(flight.end_s, last_s)) for flight in must), limits, reading),
    )


def _fired(flights: Iterable[tuple[FlightSummary, float]], limits: TriggerLimits, reading: RuleReading) -> Counts:
    """Number of the flights that fire until the time beside each."""
    step = steps_of(limits.freefall_acceleration_g, TENTH_G.per_unit)
    if step > MAX_ACCELERATION_STEPS:
        raise LookupError(limits.freefall_acceleration_g)
    count = np.zeros((len(TILTS_DEG), len(TIME_STEPS)), np.int64)
    for flight, until_s in flights:
        curves = flight.curves[reading]
        tilts = limits.attitude_is_enabled & (curves.attitude_s[TILTS_DEG] <= until_s)
        falls = limits.freefall_is_enabled & (curves.freefall_s[step, TIME_STEPS] <= until_s)
        count += tilts[:, None] | falls
    return count
