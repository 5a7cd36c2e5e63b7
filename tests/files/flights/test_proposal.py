"""Proposals for flights whose separability is known."""

from typing import NamedTuple

import numpy as np
import pytest

from app.flights.flight_log import REPORT_HZ, FlightLog
from app.flights.judge import TriggerLimits
from app.flights.judging import RuleReading, summarise
from app.flights.thresholds import FlightGroup, ThresholdProposal, propose
from tests.support.flights.made_flights import made_flight, plainly_judged

SETS, FLIGHTS_A_SET = 40, 5
CALM_S, IMPACT_S = 1.5, 0.1


class Event(NamedTuple):
    """A flight that tilts for a second, then falls."""

    tilt_deg: float
    fall_g: float
    fall_s: float


def flown(name: str, event: Event, *, hits_the_ground: bool) -> FlightLog:
    lengths = [round(one * REPORT_HZ) for one in (CALM_S, 1.0, event.fall_s, IMPACT_S, 1.0)]
    blow = 9.0 if hits_the_ground else 1.0
    tilt = np.repeat([3.0, event.tilt_deg, min(event.tilt_deg, 20.0), 20.0, 3.0], lengths)
    force = np.repeat([1.0, 1.0, event.fall_g, blow, 1.0], lengths)
    return made_flight(tilt, force, name=name)


def proposed(must_not: list[FlightLog], must: list[FlightLog]) -> ThresholdProposal:
    return propose(list(map(summarise, must_not)), list(map(summarise, must)))


def impact_of(log: FlightLog) -> float:
    return float(log.time_s[np.argmax(log.specific_force_g >= 3.0)])


def is_right(limits: TriggerLimits, must_not: list[FlightLog], must: list[FlightLog]) -> bool:
    """Judges row by row under both readings."""
    for reading in RuleReading:
        if any(plainly_judged(log, limits, reading) for log in must_not):
            return False
        for log in must:
            firings = plainly_judged(log, limits, reading)
            if not firings or firings[0][0] > impact_of(log):
                return False
    return True


@pytest.mark.promise("g")
def test_two_hundred_flights_with_known_outcome() -> None:
    random = np.random.default_rng(200)
    separable = 0
    for number in range(SETS):
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
            crash = fatal[int(random.integers(0, 2))]
            harmless.append(Event(crash.tilt_deg + 3, max(0.0, crash.fall_g - 0.05), crash.fall_s + 0.5))
        else:
            harmless.append(Event(random.uniform(5, 50), 1.0, 1.0))
        must_not = [flown(f"calm {one}", event, hits_the_ground=False) for one, event in enumerate(harmless)]
        must = [flown(f"crash {one}", event, hits_the_ground=True) for one, event in enumerate(fatal)]
        assert len(must_not) + len(must) == FLIGHTS_A_SET
        proposal = proposed(must_not, must)
        if can_be_told_apart:
            assert proposal.limits is not None, number
            assert is_right(proposal.limits, must_not, must), number
            assert proposal.conflicts == {}
            separable += 1
        else:
            assert proposal.limits is None, number
            assert any(proposal.conflicts.values()), number
    assert separable == SETS // 2


def test_margins_are_in_the_vendors_steps() -> None:
    calm = [flown("calm", Event(52.3, 0.34, 0.98), hits_the_ground=False)]
    crash = [flown("crash", Event(84.6, 1.0, 0.5), hits_the_ground=True)]
    proposal = proposed(calm, crash)
    limits = proposal.limits
    assert limits is not None
    # 52.3° is reported as 52°, 84.6° as 85°; ten degrees to each side are a full margin, so 62° to 76° are alike.
    assert limits == TriggerLimits(attitude_threshold_deg=62, freefall_acceleration_g=0.5, freefall_time_s=1.6)
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
    assert (summarise(log).impact_s is not None) is lies_on_its_side
    assert bool(plainly_judged(log, TriggerLimits())) is lies_on_its_side
    proposal = proposed([flown("calm", Event(5, 1.0, 0.5), hits_the_ground=False)], [log])
    assert proposal.limits is None
    assert proposal.conflicts[FlightGroup.MUST] == ["crash"]


ORDINARY = Event(5, 1.0, 0.5)
LOST = Event(88, 1.0, 0.5)


@pytest.mark.promise("g")
def test_flights_of_one_side_propose_nothing_and_tell_what_the_defaults_do_in_them() -> None:
    """A crash among the flights that must not fire once led to a proposal of 89°."""
    calm, crash = flown("calm", ORDINARY, hits_the_ground=False), flown("crash", LOST, hits_the_ground=True)
    found = proposed([calm, crash], [])
    assert found.limits is None
    assert found.defaults is not None
    assert (found.defaults.group, found.defaults.unexpected) == (FlightGroup.MUST_NOT, ("crash",))
    found = proposed([], [calm, crash])
    assert found.limits is None
    assert found.defaults is not None
    assert (found.defaults.group, found.defaults.unexpected) == (FlightGroup.MUST, ("calm",))
    assert proposed([], []).limits is None


def test_defaults_that_hold_only_as_far_as_a_log_is_judged_say_so() -> None:
    without = flown("tilt only", ORDINARY, hits_the_ground=False)
    without = made_flight(without.tilt_deg, np.full(len(without.time_s), np.nan), name="tilt only")
    found = proposed([without, flown("whole", ORDINARY, hits_the_ground=False)], []).defaults
    assert found is not None
    assert (found.unexpected, found.not_judged) == ((), ("tilt only",))


def test_no_margin_is_claimed_for_what_a_log_does_not_hold() -> None:
    calm, crash = flown("calm", ORDINARY, hits_the_ground=False), flown("crash", LOST, hits_the_ground=True)
    calm.specific_force_g[:] = np.nan
    nearest = proposed([calm], [crash]).nearest[FlightGroup.MUST_NOT]
    assert nearest.attitude_deg is not None
    assert nearest.freefall_s is None
    calm = flown("calm", ORDINARY, hits_the_ground=False)
    calm.tilt_deg[:] = np.nan
    nearest = proposed([calm], [crash]).nearest[FlightGroup.MUST_NOT]
    assert nearest.attitude_deg is None
    assert nearest.freefall_s is not None


@pytest.mark.promise("g")
def test_no_proposal_is_outside_its_bounds() -> None:
    random = np.random.default_rng(8)
    count = 0
    for _ in range(60):
        events = [Event(random.uniform(0, 100), random.uniform(0, 1), random.uniform(0, 2.5)) for _ in range(2)]
        must_not, must = (flown("a", event, hits_the_ground=bool(way)) for way, event in enumerate(events))
        limits = proposed([must_not], [must]).limits
        if limits is not None:
            assert 55 <= limits.attitude_threshold_deg <= 80
            assert 0.3 <= limits.freefall_acceleration_g <= 0.6
            assert 0.5 <= limits.freefall_time_s <= 2.0
            count += 1
    assert count > 10
