"""Flights that must and must not fire, and the map over thresholds."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from app.firing.judge import TriggerLimits
from app.flight_analysis.curves import MAX_ACCELERATION_STEPS, MAX_TILT_STEPS, MAX_TIME_STEPS, steps_of
from app.flight_analysis.summary import FirstFire, FlightSummary
from app.flight_logs.flight_log import Floats
from app.flight_logs.module_view import RuleReading
from protocol.catalogue import CENTISECOND, DEGREE, TENTH_G
from protocol.translatable import marked

Counts = NDArray[np.int64]
ATTITUDE_AXIS: Final = np.arange(30, 121)
"""Whole degrees."""
TIME_AXIS: Final = np.arange(20, MAX_TIME_STEPS + 1, 5) / CENTISECOND.per_unit
"""Seconds."""


class FlightGroup(Enum):
    """What a flight is expected to do; the value is the text that is shown."""

    MUST_NOT = marked("must not fire")
    MUST = marked("must fire")
    UNSORTED = marked("not sorted")


class FlightOutcome(NamedTuple):
    """First firings of one flight with given thresholds, under both readings."""

    flight: FlightSummary
    group: FlightGroup
    direct: FirstFire
    damped: FirstFire

    @property
    def is_different(self) -> bool:
        """The readings of the vendor's rule disagree on whether it fires, or fires in time."""
        direct, damped = ((bool(one.sources), one.is_in_time) for one in (self.direct, self.damped))
        return direct != damped


@dataclass(frozen=True, slots=True, eq=False)
class FireMap:
    """Number of flights that fire, by attitude threshold (rows) and free-fall time (columns).

    Acceleration threshold and enabled triggers are those of `limits`; its other two values are not used.
    """

    limits: TriggerLimits
    reading: RuleReading
    attitude_thresholds_deg: NDArray[np.int64]
    """Shape (rows,)."""
    freefall_times_s: Floats
    """Shape (columns,)."""
    must_not_count: int
    must_count: int
    must_not_fired: Counts
    """Shape (rows, columns), like all below: false triggers."""
    must_fired: Counts
    """Fired before the impact."""


class FlightSet:
    """Belongs to one thread. A flight is identified by its `name`."""

    def __init__(self) -> None:
        self._flights: dict[str, FlightSummary] = {}
        self._groups: dict[str, FlightGroup] = {}
        self._stacked: dict[tuple[FlightGroup, RuleReading], _Stacked] = {}

    def __len__(self) -> int:
        return len(self._flights)

    def add(self, flights: Iterable[FlightSummary], group: FlightGroup = FlightGroup.UNSORTED) -> None:
        """A flight of the same name is replaced."""
        for flight in flights:
            self._flights[flight.name] = flight
            self._groups[flight.name] = group
        self._stacked.clear()

    def sort(self, name: str, group: FlightGroup) -> None:
        """Raises KeyError."""
        if name not in self._flights:
            raise KeyError(name)
        self._groups[name] = group
        self._stacked.clear()

    def remove(self, name: str) -> None:
        """Raises KeyError."""
        del self._flights[name]
        del self._groups[name]
        self._stacked.clear()

    def flights(self, group: FlightGroup | None = None) -> tuple[FlightSummary, ...]:
        """Flights of a group (None: all) in the order of adding."""
        return tuple(one for name, one in self._flights.items() if group in (None, self._groups[name]))

    def outcomes(self, limits: TriggerLimits) -> tuple[FlightOutcome, ...]:
        """Outcomes of all flights in the order of adding. Raises LookupError above 1.5 g."""
        return tuple(
            FlightOutcome(one, self._groups[name], *(one.first_fire(limits, reading) for reading in RuleReading))
            for name, one in self._flights.items()
        )

    def fire_map(
        self,
        limits: TriggerLimits,
        reading: RuleReading = RuleReading.DIRECT,
        *,
        attitude_thresholds_deg: Counts = ATTITUDE_AXIS,
        freefall_times_s: Floats = TIME_AXIS,
    ) -> FireMap:
        """Takes milliseconds for a thousand flights. Raises LookupError for an acceleration above 1.5 g."""
        tilts = np.rint(np.asarray(attitude_thresholds_deg) * DEGREE.per_unit).astype(np.int64)
        times = np.rint(np.asarray(freefall_times_s) * CENTISECOND.per_unit).astype(np.int64)
        step = steps_of(limits.freefall_acceleration_g, TENTH_G.per_unit)
        if step > MAX_ACCELERATION_STEPS:
            raise LookupError(limits.freefall_acceleration_g)
        must_not, must = (
            self._stack(group, reading).cut(tilts, step, times, limits)
            for group in (FlightGroup.MUST_NOT, FlightGroup.MUST)
        )
        ends_s = np.array([flight.end_s for flight in self.flights(FlightGroup.MUST)])
        in_time = _Cut(
            np.where(must.attitude_s <= ends_s[:, None], must.attitude_s, np.inf),
            np.where(must.freefall_s <= ends_s[:, None], must.freefall_s, np.inf),
        )
        return FireMap(
            limits=limits,
            reading=reading,
            attitude_thresholds_deg=np.asarray(attitude_thresholds_deg),
            freefall_times_s=np.asarray(freefall_times_s),
            must_not_count=len(must_not.attitude_s),
            must_count=len(must.attitude_s),
            must_not_fired=must_not.fired(),
            must_fired=in_time.fired(),
        )

    def _stack(self, group: FlightGroup, reading: RuleReading) -> "_Stacked":
        key = (group, reading)
        if key not in self._stacked:
            curves = [flight.curves(reading) for flight in self.flights(group)]
            self._stacked[key] = _Stacked(
                np.array([curve.attitude_s for curve in curves]).reshape(-1, MAX_TILT_STEPS + 1),
                np.array([curve.freefall_s for curve in curves]).reshape(
                    -1, MAX_ACCELERATION_STEPS + 1, MAX_TIME_STEPS + 1
                ),
            )
        return self._stacked[key]


class _Cut(NamedTuple):
    """First firings of some flights by attitude threshold, shape (flights, rows), and by time, (flights, columns)."""

    attitude_s: Floats
    freefall_s: Floats

    def fired(self) -> Counts:
        """Number of flights fired by either trigger."""
        holds_tilt = np.isinf(self.attitude_s).astype(np.float32)
        holds_fall = np.isinf(self.freefall_s).astype(np.float32)
        fired: Counts = len(self.attitude_s) - np.rint(holds_tilt.T @ holds_fall).astype(np.int64)
        return fired


class _Stacked(NamedTuple):
    """Curves of some flights: shapes (flights, 181) and (flights, 16, 256)."""

    attitude_s: Floats
    freefall_s: Floats

    def cut(self, tilts: Counts, step: int, times: Counts, limits: TriggerLimits) -> _Cut:
        """First firings at these steps; a trigger that is off never fires, nor does a threshold above 180°."""
        attitude_s = self.attitude_s[:, np.minimum(tilts, MAX_TILT_STEPS)]
        attitude_s[:, (tilts > MAX_TILT_STEPS) | (not limits.attitude_is_enabled)] = np.inf
        freefall_s = self.freefall_s[:, step, :][:, times]
        if not limits.freefall_is_enabled:
            freefall_s = np.full_like(freefall_s, np.inf)
        return _Cut(attitude_s, freefall_s)
