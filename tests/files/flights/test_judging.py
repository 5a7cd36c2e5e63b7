"""The rule sample by sample, curves and map that agree with it, when control was lost, and what is proposed."""

from itertools import product
from typing import NamedTuple

import numpy as np
import pytest

from app.flights.flight_log import REPORT_HZ, FlightLog
from app.flights.judge import Judge, SensorSample, TriggerLimits
from app.flights.judging import (
    NEVER,
    TILTS_DEG,
    TIMES_S,
    Answer,
    FlightGroup,
    FlightSummary,
    ThresholdProposal,
    defaults_result,
    fire_map,
    loss_of_control,
    propose,
)
from protocol.messages import Source
from tests.support.flights.made_flights import made_flight, plainly_judged, random_flight

ROWS = 500
TIMES = np.arange(ROWS) / 50
STEP_S = 0.01

# The rule


def firings(samples: list[SensorSample]) -> list[tuple[float, float, Source]]:
    """Times and tilts at which it fires, and why."""
    judge = Judge()
    verdicts = [(one.at_s, one.tilt_deg, judge.judge(one, TriggerLimits()).fired) for one in samples]
    return [verdict for verdict in verdicts if verdict[2]]


@pytest.mark.parametrize(("tilts", "fires_at"), [
    (list(range(90)), [60]), ([0, 60, 51, 60], [60]), ([0, 60, 50, 60], [60, 60]),
])  # fmt: skip
def test_attitude_fires_at_the_threshold_and_rearms_ten_degrees_below(tilts: list[int], fires_at: list[int]) -> None:
    found = firings([SensorSample(number * STEP_S, tilt, 1.0) for number, tilt in enumerate(tilts)])
    assert [(tilt, source) for _, tilt, source in found] == [(tilt, Source.ATTITUDE) for tilt in fires_at]


def fall(duration_s: float, *, acceleration_g: float = 0.1) -> list[SensorSample]:
    """A second of rest, a fall, and a second of rest."""
    forces = [1.0] * 100 + [acceleration_g] * round(duration_s / STEP_S) + [1.0] * 100
    return [SensorSample(step * STEP_S, 0.0, force) for step, force in enumerate(forces)]


def with_weight(samples: list[SensorSample], row: int) -> list[SensorSample]:
    return [*samples[:row], samples[row]._replace(acceleration_g=1.0), *samples[row + 1 :]]


@pytest.mark.parametrize(("samples", "fires_s"), [
    (fall(1.59), []), (fall(1.62), [2.6]),
    (fall(3.0, acceleration_g=0.5), []), (fall(3.0, acceleration_g=0.49), [2.6]),
    (with_weight(fall(3.0), 200), [2.01 + 1.6]),
    ([SensorSample(0.0, 0.0, 0.0), SensorSample(2.0, 0.0, 0.0), SensorSample(2.1, 0.0, 0.0)], []),
])  # fmt: skip
def test_free_fall_fires_after_its_time_below_the_threshold_without_a_pause(
    samples: list[SensorSample], fires_s: list[float]
) -> None:
    found = firings(samples)
    assert [(at_s, source) for at_s, _, source in found] == [(pytest.approx(at_s), Source.FREEFALL) for at_s in fires_s]


# Curves and map


@pytest.mark.promise("g")
def test_a_summary_agrees_with_the_judge() -> None:
    random = np.random.default_rng(14)
    fired = 0
    for _ in range(100):
        log = random_flight(random)
        flight = FlightSummary(log)
        for _ in range(5):
            limits = TriggerLimits(
                attitude_threshold_deg=int(random.integers(0, 200)),
                freefall_acceleration_g=int(random.integers(0, 16)) / 10,
                freefall_time_s=int(random.integers(0, 256)) / 100,
                attitude_is_enabled=bool(random.random() < 0.6),
                freefall_is_enabled=bool(random.random() < 0.8),
            )
            judged, found = plainly_judged(log, limits), flight.outcome(limits)
            assert (found.at_s, found.sources) == (judged[0] if judged else (NEVER, Source(0)))
            assert (found.answer is Answer.FIRES) is bool(judged)
            fired += bool(judged)
    assert 100 < fired < 470
    with pytest.raises(LookupError):
        flight.outcome(TriggerLimits(freefall_acceleration_g=1.6))


def crash(lies_deg: float = 88.0) -> FlightLog:
    """Tips over from 3.0 s on by 30° a second, falls from 3.5 s on, hits the ground at 6.0 s from 45 m."""
    tilt = np.where(TIMES > 6.0, lies_deg, np.clip(30 * (TIMES - 3.0), 0, 88))
    force = np.select([TIMES < 3.5, TIMES < 6.0, TIMES < 6.06], [1.0, 0.2, 12.0], 1.0)
    return made_flight(tilt, force, altitude_m=45.0 - 5 * np.clip(TIMES - 3.0, 0, 3.0) ** 2)


def test_the_map_counts_the_outcome_of_each_flight() -> None:
    random = np.random.default_rng(5)
    must_not, must = ([FlightSummary(random_flight(random)) for _ in range(7)] for _ in range(2))
    must[0] = FlightSummary(crash(120.0))
    must.append(FlightSummary(crash()))
    for limits in (
        TriggerLimits(),
        TriggerLimits(freefall_acceleration_g=0.3, attitude_is_enabled=False),
        TriggerLimits(freefall_acceleration_g=1.5, freefall_is_enabled=False),
    ):
        wrong, missed = fire_map(must_not, must, limits)
        for row, column in product((0, 15, 30, 60, len(TILTS_DEG) - 1), (0, 16, 28, len(TIMES_S) - 1)):
            at = limits._replace(attitude_threshold_deg=TILTS_DEG[row], freefall_time_s=TIMES_S[column])
            fired = sum(flight.outcome(at).answer is Answer.FIRES for flight in must_not)
            late = sum(not flight.outcome(at).is_before_impact for flight in must)
            assert (wrong[row, column], missed[row, column]) == (fired / 7, late / 8)


# Loss of control


def shaken(*rows: int, force_g: float = 5.0) -> np.ndarray:
    force = np.ones(ROWS)
    force[list(rows)] = force_g
    return force


def wreck(highest_g: float = 12.0) -> FlightLog:
    """It flips, crashes and lies level for a while, then somebody picks it up and drops it."""
    tilt = np.select([TIMES < 3.0, TIMES < 6.0, TIMES < 9.0], [0.0, 120.0, 5.0], 80.0)
    force = np.select([TIMES < 3.0, TIMES < 6.0, TIMES < 6.06], [1.0, 0.2, 12.0], 1.0)
    force[470] = 5.0
    altitude = 45.0 - 5 * np.clip(TIMES - 3.0, 0, 3.0) ** 2
    return made_flight(tilt, np.minimum(force, highest_g), altitude_m=altitude)


TIPS_OVER = np.where(TIMES >= 4, 70.0, 0.0)
LOSSES = {
    "calm to its end": (made_flight(np.full(ROWS, 5.0), 1.0), None, None),
    "empty": (made_flight(np.full(0, 5.0), np.ones(0)), None, None),
    "a hard landing": (made_flight(5.0, shaken(400, force_g=4.0)), None, 8.0),
    "shocks, then calm, then it tips over until the end": (
        made_flight(np.where(TIMES >= 6, 80.0, 0.0), shaken(*range(100, 125), force_g=4.0)), 5.98, None,
    ),
    "shocks close together are one impact": (made_flight(TIPS_OVER, shaken(100, 250, 280, 340)), 3.98, 5.0),
    "it flips, flies on and is lost later": (
        made_flight(np.select([TIMES < 2.0, TIMES < 2.5, TIMES < 8.0], [0.0, 150.0, 5.0], 90.0), 1.0), 7.98, None,
    ),
    "a wreck that is picked up and dropped": (wreck(), 2.98, 6.0),
    "a wreck that hit the ground softly": (wreck(highest_g=2.0), 2.98, pytest.approx(6.0, abs=0.1)),
}  # fmt: skip


@pytest.mark.parametrize("case", LOSSES)
def test_when_control_was_lost_and_it_hit_the_ground(case: str) -> None:
    log, loss_s, impact_s = LOSSES[case]
    assert loss_of_control(log) == (None if loss_s is None else pytest.approx(loss_s), impact_s)


# Proposals


class Event(NamedTuple):
    """A flight that tilts for a second, then falls."""

    tilt_deg: float
    fall_g: float
    fall_s: float


def flown(name: str, event: Event, *, hits_the_ground: bool = False) -> FlightLog:
    lengths = [round(one * REPORT_HZ) for one in (1.5, 1.0, event.fall_s, 0.1, 1.0)]
    blow = 9.0 if hits_the_ground else 1.0
    tilt = np.repeat([3.0, event.tilt_deg, min(event.tilt_deg, 20.0), 20.0, 3.0], lengths)
    force = np.repeat([1.0, 1.0, event.fall_g, blow, 1.0], lengths)
    return made_flight(tilt, force, name=name)


ORDINARY, LOST = flown("calm", Event(5, 1.0, 0.5)), flown("crash", Event(88, 1.0, 0.5), hits_the_ground=True)


def proposed(must_not: list[FlightLog], must: list[FlightLog]) -> ThresholdProposal:
    return propose(list(map(FlightSummary, must_not)), list(map(FlightSummary, must)))


def is_right(limits: TriggerLimits, must_not: list[FlightLog], must: list[FlightLog]) -> bool:
    """Judges row by row."""
    if any(plainly_judged(log, limits) for log in must_not):
        return False
    impacts_s = [float(log.time_s[np.argmax(log.specific_force_g >= 3.0)]) for log in must]
    found = [plainly_judged(log, limits) for log in must]
    return all(one and one[0][0] <= impact_s for one, impact_s in zip(found, impacts_s, strict=True))


@pytest.mark.promise("g")
def test_two_hundred_flights_with_known_outcome() -> None:
    random = np.random.default_rng(200)
    for number in range(40):
        tilt, acceleration = int(random.integers(57, 78)), int(random.integers(3, 7)) / 10
        time_s = int(random.integers(60, 190)) / 100
        harmless = [
            Event(random.uniform(5, tilt - 2), random.uniform(0, acceleration), random.uniform(0, time_s - 0.2)),
            Event(random.uniform(5, tilt - 2), acceleration + 0.1, random.uniform(0, 3)),
        ]
        fatal = [
            Event(random.uniform(tilt + 2, 170), 1.0, random.uniform(0, 1)),
            Event(random.uniform(5, 50), random.uniform(0, acceleration - 0.06), time_s + 0.3),
        ]
        can_be_told_apart = bool(number % 2)
        if not can_be_told_apart:  # a normal flight that is worse than a crash in every value
            worst = fatal[int(random.integers(0, 2))]
            harmless.append(Event(worst.tilt_deg + 3, max(0.0, worst.fall_g - 0.05), worst.fall_s + 0.5))
        must_not = [flown(f"calm {one}", event) for one, event in enumerate(harmless)]
        must = [flown(f"crash {one}", event, hits_the_ground=True) for one, event in enumerate(fatal)]
        proposal = proposed(must_not, must)
        if can_be_told_apart:
            assert proposal.limits is not None, number
            assert is_right(proposal.limits, must_not, must), number
            assert proposal.conflicts == {}
        else:
            assert proposal.limits is None, number
            assert any(proposal.conflicts.values()), number


def test_margins_are_in_the_vendors_steps() -> None:
    proposal = proposed([flown("calm", Event(52.3, 0.34, 0.98))], [flown("crash", Event(84.6, 1.0, 0.5))])
    # 52.3° is reported as 52°, 84.6° as 85°; ten degrees to each side are a full margin, so 62° to 76° are alike.
    assert proposal.limits == TriggerLimits(62, 0.5, 1.6)
    must_not, must = proposal.nearest[FlightGroup.MUST_NOT], proposal.nearest[FlightGroup.MUST]
    assert (must_not.name, must_not.attitude_deg) == ("calm", 10)
    assert must_not.freefall_s == pytest.approx(1.6 - 0.96)  # of 49 reports, from the first to the last
    assert (must.name, must.attitude_deg) == ("crash", 85 - 62)


@pytest.mark.parametrize("lies_on_its_side", [True, False])
@pytest.mark.promise("g")
def test_a_crash_that_fires_only_after_the_impact_or_never_has_no_proposal(lies_on_its_side: bool) -> None:
    """Else it is lost over the sea: its log ends without an impact."""
    log = flown("crash", Event(5, 1.0, 0.5), hits_the_ground=lies_on_its_side)
    if lies_on_its_side:
        log.tilt_deg[-30:] = 95.0
    assert (FlightSummary(log).impact_s is not None) is lies_on_its_side
    proposal = proposed([ORDINARY], [log])
    assert proposal.limits is None
    assert proposal.conflicts[FlightGroup.MUST] == ["crash"]


@pytest.mark.promise("g")
def test_flights_of_one_side_propose_nothing_and_tell_what_the_defaults_do_in_them() -> None:
    """A crash among the flights that must not fire once led to a proposal of 89°."""
    tilt_only = made_flight(ORDINARY.tilt_deg, np.full(len(ORDINARY.time_s), np.nan), name="tilt only")
    assert proposed([ORDINARY, LOST, tilt_only], []).limits is None
    must_not = [FlightSummary(log) for log in (ORDINARY, LOST, tilt_only)]
    assert defaults_result(must_not, FlightGroup.MUST_NOT) == (["crash"], ["tilt only"])
    assert proposed([], [ORDINARY, LOST]).limits is None
    assert defaults_result(must_not[:2], FlightGroup.MUST) == (["calm"], [])
    assert proposed([], []).limits is None


@pytest.mark.parametrize("unknown", ["tilt_deg", "specific_force_g"])
def test_no_margin_is_claimed_for_what_a_log_does_not_hold(unknown: str) -> None:
    calm = flown("calm", Event(5, 1.0, 0.5))
    getattr(calm, unknown)[:] = np.nan
    nearest = proposed([calm], [LOST]).nearest[FlightGroup.MUST_NOT]
    assert (nearest.attitude_deg is None, nearest.freefall_s is None) == (unknown == "tilt_deg", unknown != "tilt_deg")


@pytest.mark.promise("g")
def test_no_proposal_is_outside_its_bounds() -> None:
    random = np.random.default_rng(8)
    count = 0
    for _ in range(60):
        calm, lost = (Event(random.uniform(0, 100), random.uniform(0, 1), random.uniform(0, 2.5)) for _ in range(2))
        limits = proposed([flown("a", calm)], [flown("b", lost, hits_the_ground=True)]).limits
        if limits is not None:
            assert 55 <= limits.attitude_threshold_deg <= 80
            assert 0.3 <= limits.freefall_acceleration_g <= 0.6
            assert 0.5 <= limits.freefall_time_s <= 2.0
            count += 1
    assert count > 10
