"""Proposes thresholds that separate the flights that must fire from those that must not, with margins.

A proposal can kill, so it stays within the narrow bounds of this program. Under both readings of the vendor's rule no
flight fires that must not, and each fires before the impact that must. Flights of one side alone propose nothing: they
only tell what the vendor's defaults do in them.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from app.flights.answer import Answer
from app.flights.curves import MAX_ACCELERATION_STEPS, NEVER, steps_of
from app.flights.fire_map import FlightGroup
from app.flights.judge import TriggerLimits
from app.flights.module_view import RuleReading
from app.flights.summary import FlightSummary
from app.safety.consequences import SHORT_FALL_S
from app.text.messages import UserMessage, message
from protocol.catalogue import CENTISECOND, DEGREE, TENTH_G
from protocol.fields import Value
from protocol.translatable import marked

Steps = NDArray[np.int64]
FULL_MARGIN_DEG: Final = 10
FULL_MARGIN_S: Final = 0.3
"""Margins count up to these; among equal proposals the one nearest to the vendor's defaults is chosen."""
MAX_CONFLICTS: Final = 20


class FlightMargin(NamedTuple):
    """Distance of one flight from the thresholds of a proposal."""

    name: str
    group: FlightGroup
    # None where the log holds no attitude, or no acceleration: of what a log does not hold no margin is known.
    attitude_deg: int | None
    """Must not fire: threshold minus largest tilt. Must fire: tilt reached in time minus threshold, negative where this
    trigger alone would not fire."""
    freefall_s: float | None
    """Must not fire: free-fall time minus longest fall. Must fire: longest fall in time minus free-fall time."""


class SeparationConflict(NamedTuple):
    """A flight because of which no thresholds separate the lists."""

    name: str
    group: FlightGroup
    why: UserMessage


class DefaultsResult(NamedTuple):
    """What the vendor's defaults do in the flights of one side, while the other side is empty."""

    group: FlightGroup
    total: int
    unexpected: tuple[str, ...]
    """The flights that fire and must not, or that must and do not fire in time under each reading."""
    not_judged: tuple[str, ...]
    """The flights that do not fire, but hold too little to say so."""


class ThresholdProposal(NamedTuple):
    """`limits` is None where no thresholds separate the lists; `conflicts` then says why.

    It is None, too, where one side is empty; `defaults` then says what the vendor's defaults do.
    """

    limits: TriggerLimits | None
    margins: tuple[FlightMargin, ...] = ()
    """Per flight, smallest first; those that must not fire before those that must."""
    conflicts: tuple[SeparationConflict, ...] = ()
    defaults: DefaultsResult | None = None

    @property
    def settings(self) -> dict[str, Value]:
        """Thresholds by the names of profiles and `dps-s set`; empty where there are none."""
        return {} if self.limits is None else settings_of(self.limits)

    def nearest(self, group: FlightGroup) -> FlightMargin | None:
        """The flight of a group with the smallest margin; None for an empty group."""
        return next((margin for margin in self.margins if margin.group is group), None)


def settings_of(limits: TriggerLimits) -> dict[str, Value]:
    """Thresholds by the names of profiles and `dps-s set`, in the vendor's steps."""
    return {
        "attitude_threshold_deg": round(limits.attitude_threshold_deg),
        "freefall_acceleration_g": round(limits.freefall_acceleration_g, 1),
        "freefall_time_s": round(limits.freefall_time_s, 2),
    }


def propose(must_not: Sequence[FlightSummary], must: Sequence[FlightSummary]) -> ThresholdProposal:
    """Takes about 0.1 s for hundreds of flights."""
    if not must_not or not must:
        group = FlightGroup.MUST if must else FlightGroup.MUST_NOT
        return ThresholdProposal(None, defaults=defaults_result(must or must_not, group))
    calm, lost = _Reached.of(must_not, FlightGroup.MUST_NOT), _Reached.of(must, FlightGroup.MUST)
    best = _best(calm, lost)
    if best is None:
        return ThresholdProposal(None, conflicts=_conflicts(calm, lost))
    limits = TriggerLimits(
        attitude_threshold_deg=best.tilt / DEGREE.per_unit,
        freefall_acceleration_g=best.acceleration / TENTH_G.per_unit,
        freefall_time_s=best.time / CENTISECOND.per_unit,
    )
    return ThresholdProposal(limits, (*calm.margins(best), *lost.margins(best)))


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


class _Thresholds(NamedTuple):
    """In the vendor's steps."""

    tilt: int
    acceleration: int
    time: int


class _Reached(NamedTuple):
    """Largest thresholds at which the flights of a group fire, in the vendor's steps; -1: none."""

    group: FlightGroup
    names: tuple[str, ...]
    tilt: Steps
    """Shape (flights,)."""
    fall: Steps
    """Shape (flights, 16): largest free-fall time, by acceleration threshold."""
    has_attitude: tuple[bool, ...]
    has_acceleration: tuple[bool, ...]

    @classmethod
    def of(cls, flights: Sequence[FlightSummary], group: FlightGroup) -> "_Reached":
        """Uses the worse reading: the larger value for flights that must not fire, the smaller for those that must."""
        worse = max if group is FlightGroup.MUST_NOT else min
        tilts, falls = [], []
        for flight in flights:
            # Finite: what never fires has the time infinity, which is not before an impact that is unknown.
            end_s = min(flight.end_s if group is FlightGroup.MUST else NEVER, np.finfo(np.float64).max)
            curves = flight.curves.values()
            tilts.append(worse(int((curve.attitude_s <= end_s).sum()) - 1 for curve in curves))
            both = np.stack([(curve.freefall_s <= end_s).sum(axis=1) - 1 for curve in curves])
            falls.append(both.max(axis=0) if group is FlightGroup.MUST_NOT else both.min(axis=0))
        return cls(
            group,
            tuple(flight.name for flight in flights),
            np.array(tilts, np.int64),
            np.array(falls, np.int64).reshape(-1, MAX_ACCELERATION_STEPS + 1),
            tuple(flight.has_attitude for flight in flights),
            tuple(flight.has_acceleration for flight in flights),
        )

    def margins(self, thresholds: _Thresholds) -> list[FlightMargin]:
        sign = 1 if self.group is FlightGroup.MUST_NOT else -1
        tilt = sign * (thresholds.tilt - self.tilt)
        fall = sign * (thresholds.time - self.fall[:, thresholds.acceleration])
        worse = np.minimum if self.group is FlightGroup.MUST_NOT else np.maximum
        nearness = worse(tilt / FULL_TILT_STEPS, fall / FULL_TIME_STEPS)
        return [
            FlightMargin(
                self.names[flight],
                self.group,
                int(tilt[flight]) if self.has_attitude[flight] else None,
                int(fall[flight]) / CENTISECOND.per_unit if self.has_acceleration[flight] else None,
            )
            for flight in np.argsort(nearness, kind="stable").tolist()
        ]


FULL_TILT_STEPS: Final = FULL_MARGIN_DEG * DEGREE.per_unit
FULL_TIME_STEPS: Final = round(FULL_MARGIN_S * CENTISECOND.per_unit)


def _steps_between(low: float, high: float, per_unit: int) -> Steps:
    return np.arange(steps_of(low, per_unit), steps_of(high, per_unit) + 1)


# The bounds of a proposal are this program's. The vendor's table says less: 55° and up, below 0.7 g, and the defaults.
LEAST_TILT_DEG: Final = 55
MOST_TILT_DEG: Final = 80
LEAST_ACCELERATION_G: Final = 0.3
MOST_ACCELERATION_G: Final = 0.6
LEAST_FALL_S: Final = SHORT_FALL_S
MOST_FALL_S: Final = 2.0
TILTS: Final = _steps_between(LEAST_TILT_DEG, MOST_TILT_DEG, DEGREE.per_unit)
ACCELERATIONS: Final = _steps_between(LEAST_ACCELERATION_G, MOST_ACCELERATION_G, TENTH_G.per_unit)
TIMES: Final = _steps_between(LEAST_FALL_S, MOST_FALL_S, CENTISECOND.per_unit)


def _best(must_not: _Reached, must: _Reached) -> _Thresholds | None:
    """Thresholds with the largest minimum margin, up to `FULL_MARGIN_*`; None where none separate."""
    usual = TriggerLimits()
    best: _Thresholds | None = None
    best_score = (0.0, 0.0)
    for acceleration in ACCELERATIONS.tolist():
        least = np.minimum(
            _share(TILTS - must_not.tilt.max(initial=-FULL_TILT_STEPS), FULL_TILT_STEPS)[:, None],
            _share(TIMES - must_not.fall[:, acceleration].max(initial=-FULL_TIME_STEPS), FULL_TIME_STEPS)[None, :],
        )
        for tilt, fall in _hardest(must.tilt, must.fall[:, acceleration]):
            # One step more than the margin, since a flight that just reaches the threshold fires.
            reached = np.maximum(
                _share(tilt - TILTS + 1, FULL_TILT_STEPS)[:, None], _share(fall - TIMES + 1, FULL_TIME_STEPS)[None, :]
            )
            least = np.minimum(least, reached)
        distance = (
            np.abs(TILTS - steps_of(usual.attitude_threshold_deg, DEGREE.per_unit))[:, None] / FULL_TILT_STEPS
            + np.abs(TIMES - steps_of(usual.freefall_time_s, CENTISECOND.per_unit))[None, :] / FULL_TIME_STEPS
            + abs(acceleration - steps_of(usual.freefall_acceleration_g, TENTH_G.per_unit))
        )
        largest = float(least.max())
        nearest = np.where(least == largest, -distance, -np.inf)
        row, column = np.unravel_index(int(nearest.argmax()), nearest.shape)
        score = (largest, float(nearest[row, column]))
        if largest > 0 and (best is None or score > best_score):
            best, best_score = _Thresholds(int(TILTS[row]), acceleration, int(TIMES[column])), score
    return best


def _share(steps: Steps, full: int) -> NDArray[np.float64]:
    """0 without a margin, 1 for a full one."""
    return np.clip(steps / full, 0.0, 1.0)


def _hardest(tilt: Steps, fall: Steps) -> list[tuple[int, int]]:
    """The flights that must fire for which no other has both a smaller tilt and a shorter fall."""
    kept: list[tuple[int, int]] = []
    shortest = None
    for pair in sorted(set(zip(tilt.tolist(), fall.tolist(), strict=True))):
        if shortest is None or pair[1] < shortest:
            kept.append(pair)
            shortest = pair[1]
    return kept


def _conflicts(must_not: _Reached, must: _Reached) -> tuple[SeparationConflict, ...]:
    conflicts: list[SeparationConflict] = []
    most_deg, most_s = int(TILTS[-1]), int(TIMES[-1])
    for name, tilt, falls in zip(must_not.names, must_not.tilt.tolist(), must_not.fall, strict=True):
        if tilt >= most_deg:
            why = message(marked("Tilts to {tilt}°: too far for a proposal."), tilt=tilt)
        elif int(falls[ACCELERATIONS].min()) >= most_s:
            why = message(marked("Falls for too long for a proposal."))
        else:
            continue
        conflicts.append(SeparationConflict(name, FlightGroup.MUST_NOT, why))
    if not conflicts:
        conflicts += _missed(must_not, must)
    return tuple(conflicts[:MAX_CONFLICTS])


def _missed(must_not: _Reached, must: _Reached) -> list[SeparationConflict]:
    """Flights that must fire but do not at the most sensitive thresholds at which no other fires."""
    tilt = max(int(TILTS[0]), int(must_not.tilt.max(initial=-1)) + 1)
    times = np.maximum(int(TIMES[0]), must_not.fall.max(axis=0, initial=-1) + 1)
    best: NDArray[np.bool_] | None = None
    best_acceleration = int(ACCELERATIONS[0])
    for acceleration in ACCELERATIONS.tolist():
        can_fall = int(times[acceleration]) <= int(TIMES[-1])
        is_missed = (must.tilt < tilt) & ((must.fall[:, acceleration] < times[acceleration]) | (not can_fall))
        if can_fall and (best is None or is_missed.sum() < best.sum()):
            best, best_acceleration = is_missed, acceleration
    if best is None:
        return []
    return [
        SeparationConflict(
            must.names[flight],
            FlightGroup.MUST,
            message(
                marked("Missed at {tilt}°, {acceleration:.1f} g and {time:.2f} s, where the others pass."),
                tilt=tilt, acceleration=best_acceleration / TENTH_G.per_unit,
                time=int(times[best_acceleration]) / CENTISECOND.per_unit,
            ),
        )
        for flight in np.flatnonzero(best).tolist()
    ]  # fmt: skip
