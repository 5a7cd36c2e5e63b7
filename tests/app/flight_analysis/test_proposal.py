"""Proposals for flights whose separability is known; where in a flight log a trigger record may have been made."""

from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from app.firing.judge import TriggerLimits
from app.flight_analysis.curves import judge_flight
from app.flight_analysis.fire_map import FlightGroup
from app.flight_analysis.proposal import ThresholdProposal, propose
from app.flight_analysis.record_match import MAX_MOMENTS, match_record, measured_text, moment_message
from app.flight_analysis.summary import summarise
from app.flight_logs.flight_log import REPORT_HZ, FlightLog
from app.flight_logs.module_view import RuleReading
from app.simulator.memory import Memory, record_frame
from app.trigger_records.history import record_of
from protocol.messages import Source, TriggerRecord
from tests.app.flight_analysis.test_fire_map import module_fires, sensed_flight
from tests.support.flights.made_flights import made_flight, random_flight

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
        if any(judge_flight(log, limits, reading).firings for log in must_not):
            return False
        for log in must:
            firings = judge_flight(log, limits, reading).firings
            if not firings or firings[0].at_s > impact_of(log):
                return False
    return True


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
            assert proposal.conflicts == ()
            separable += 1
        else:
            assert proposal.limits is None, number
            assert proposal.conflicts, number
    assert separable == SETS // 2


def test_margins_are_in_the_vendors_steps() -> None:
    calm = [flown("calm", Event(52.3, 0.34, 0.98), hits_the_ground=False)]
    crash = [flown("crash", Event(84.6, 1.0, 0.5), hits_the_ground=True)]
    proposal = proposed(calm, crash)
    limits = proposal.limits
    assert limits is not None
    # 52.3° is reported as 52°, 84.6° as 85°; ten degrees to each side are a full margin, so 62° to 76° are alike.
    assert limits == TriggerLimits(attitude_threshold_deg=62, freefall_acceleration_g=0.5, freefall_time_s=1.6)
    must_not, must = proposal.nearest(FlightGroup.MUST_NOT), proposal.nearest(FlightGroup.MUST)
    assert must_not is not None
    assert must is not None
    assert (must_not.name, must_not.attitude_deg) == ("calm", 10)
    assert must_not.freefall_s == pytest.approx(1.6 - 0.96)  # of 49 reports, from the first to the last
    assert (must.name, must.attitude_deg) == ("crash", 85 - 62)


def test_an_acceleration_step_alone_can_separate() -> None:
    """Both fall for two seconds, one of them less deep."""
    calm = [flown("calm", Event(5, 0.35, 2.2), hits_the_ground=False)]
    crash = [flown("crash", Event(5, 0.05, 2.2), hits_the_ground=True)]
    assert proposed(calm, []).limits is None
    limits = proposed(calm, crash).limits
    assert limits is not None
    assert is_right(limits, calm, crash)


def test_an_inverted_flight_excludes_every_attitude_threshold() -> None:
    fell = flown("fell", Event(5, 0.1, 2.2), hits_the_ground=True)
    proposal = proposed([flown("aerobatics", Event(178.2, 1.0, 0.5), hits_the_ground=False)], [fell])
    assert proposal.limits is None
    (conflict,) = proposal.conflicts
    assert (conflict.name, conflict.group) == ("aerobatics", FlightGroup.MUST_NOT)
    assert conflict.why.in_english() == "Tilts to 178°: too far for a proposal."


@pytest.mark.parametrize("lies_on_its_side", [True, False])
def test_a_crash_that_fires_only_after_the_impact_or_never_has_no_proposal(lies_on_its_side: bool) -> None:
    """Else it is lost over the sea: its log ends without an impact."""
    log = flown("crash", Event(5, 1.0, 0.5), hits_the_ground=lies_on_its_side)
    if lies_on_its_side:
        log.tilt_deg[-30:] = 95.0
    assert (summarise(log).impact_s is not None) is lies_on_its_side
    assert bool(judge_flight(log, TriggerLimits()).firings) is lies_on_its_side
    proposal = proposed([flown("calm", Event(5, 1.0, 0.5), hits_the_ground=False)], [log])
    assert proposal.limits is None
    assert [conflict.name for conflict in proposal.conflicts] == ["crash"]


def test_a_flight_without_an_impact_that_fires_late_has_its_true_margin() -> None:
    log = flown("lost over the sea", Event(85, 1.0, 0.5), hits_the_ground=False)
    proposal = proposed([flown("calm", Event(5, 1.0, 0.5), hits_the_ground=False)], [log])
    nearest, limits = proposal.nearest(FlightGroup.MUST), proposal.limits
    assert nearest is not None
    assert limits is not None
    assert nearest.attitude_deg == 85 - limits.attitude_threshold_deg
    assert nearest.freefall_s is not None
    assert nearest.freefall_s < 0


ORDINARY = Event(5, 1.0, 0.5)
LOST = Event(88, 1.0, 0.5)


def test_flights_of_one_side_propose_nothing_and_tell_what_the_defaults_do_in_them() -> None:
    """A crash among the flights that must not fire once led to a proposal of 89°."""
    calm, crash = flown("calm", ORDINARY, hits_the_ground=False), flown("crash", LOST, hits_the_ground=True)
    found = proposed([calm, crash], [])
    assert found.limits is None
    assert found.settings == {}
    assert found.defaults is not None
    assert (found.defaults.group, found.defaults.unexpected) == (FlightGroup.MUST_NOT, ("crash",))
    found = proposed([], [calm, crash])
    assert found.limits is None
    assert found.defaults is not None
    assert (found.defaults.group, found.defaults.unexpected) == (FlightGroup.MUST, ("calm",))
    assert proposed([], []).limits is None


def test_defaults_that_hold_only_as_far_as_a_log_is_judged_say_so() -> None:
    without = flown("tilt only", ORDINARY, hits_the_ground=False)
    without.specific_force_g[:] = np.nan
    found = proposed([without, flown("whole", ORDINARY, hits_the_ground=False)], []).defaults
    assert found is not None
    assert (found.unexpected, found.not_judged) == ((), ("tilt only",))


def test_no_margin_is_claimed_for_what_a_log_does_not_hold() -> None:
    calm, crash = flown("calm", ORDINARY, hits_the_ground=False), flown("crash", LOST, hits_the_ground=True)
    calm.specific_force_g[:] = np.nan
    nearest = proposed([calm], [crash]).nearest(FlightGroup.MUST_NOT)
    assert nearest is not None
    assert nearest.attitude_deg is not None
    assert nearest.freefall_s is None
    calm = flown("calm", ORDINARY, hits_the_ground=False)
    calm.tilt_deg[:] = np.nan
    nearest = proposed([calm], [crash]).nearest(FlightGroup.MUST_NOT)
    assert nearest is not None
    assert nearest.attitude_deg is None
    assert nearest.freefall_s is not None


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


ATTITUDE, FREEFALL, SERIAL, PWM = Source.ATTITUDE, Source.FREEFALL, Source.SERIAL, Source.PWM
FLIGHTS = 200


def record(sources: Source, *, tilt: int = 60, force: int = 5, fall: int = 160, uptime_s: int = 108) -> TriggerRecord:
    """`force` and `fall` in the vendor's steps."""
    data = (1, *divmod(uptime_s, 256), sources.value, tilt, force, fall, 0, 1, 3, 200)
    return record_of(record_frame(bytes(data)))


def flight(*pieces: tuple[float, float, float], is_judged: bool = True) -> FlightLog:
    """Pieces of seconds, degrees and g, at 50 rows a second."""
    rows = np.concatenate([np.tile(piece[1:], (round(piece[0] * 50), 1)) for piece in pieces])
    tilt, force = rows.T
    return made_flight(tilt, force, name="flight.ulg", is_judged=np.full(len(rows), is_judged))


LEVEL = (10.0, 2.0, 1.0)
TIPPED = (1.0, 75.0, 1.0)
FALLEN = (2.0, 2.0, 0.1)
UNKNOWN: NDArray[np.float64] = np.full(100, np.nan)


@pytest.mark.parametrize(("made", "log", "moments_s", "measured"), [
    (record(ATTITUDE), flight(LEVEL, TIPPED, LEVEL), [10.0], ["75°"]),
    (record(FREEFALL), flight(LEVEL, FALLEN, LEVEL), [11.6], ["0.1 g"]),
    (record(FREEFALL, fall=100), flight(LEVEL, FALLEN, LEVEL), [11.0], ["0.1 g"]),
    (record(ATTITUDE), flight(LEVEL, TIPPED, LEVEL, TIPPED, LEVEL), [10.0, 21.0], ["75°", "75°"]),
    (record(ATTITUDE | FREEFALL), flight(LEVEL, (2.0, 75.0, 0.1), LEVEL), [11.6], ["75° · 0.1 g"]),
    (record(ATTITUDE | SERIAL), flight(LEVEL, TIPPED), [10.0], ["75°"]),  # the serial part leaves no trace
    (record(ATTITUDE, tilt=75), flight(LEVEL, TIPPED), [10.0], ["75°"]),
])  # fmt: skip
def test_the_moments_at_which_the_log_meets_the_record(
    made: TriggerRecord, log: FlightLog, moments_s: list[float], measured: list[str]
) -> None:
    match = match_record(made, log)
    assert match.why_none is None
    assert [moment.firing.at_s for moment in match.moments] == pytest.approx(moments_s)
    assert [measured_text(moment.firing) for moment in match.moments] == measured
    assert match.likeliest is match.moments[0]


@pytest.mark.parametrize(("made", "log", "why"), [
    (record(SERIAL), flight(LEVEL, TIPPED), "No flight log shows this cause: fired by serial."),
    (record(PWM), flight(LEVEL, TIPPED), "No flight log shows this cause: fired by PWM."),
    (record(SERIAL | PWM), flight(LEVEL, TIPPED),
     "No flight log shows this cause: fired by serial + fired by PWM."),
    (record(Source(0)), flight(LEVEL, TIPPED), "No flight log shows this cause: no cause stated."),
    (record(ATTITUDE, tilt=76), flight(LEVEL, TIPPED), "No moment of this log matches: tilt at most 75°."),
    (record(ATTITUDE), flight(LEVEL, FALLEN), "No moment of this log matches: tilt at most 2°."),
    (record(FREEFALL), flight(LEVEL, TIPPED),
     "No moment of this log matches: longest free fall below 0.5 g: 0.00 s."),
    (record(FREEFALL, fall=220), flight(LEVEL, FALLEN, LEVEL),
     "No moment of this log matches: longest free fall below 0.5 g: 1.98 s."),
    (record(FREEFALL, force=1), flight(LEVEL, FALLEN, LEVEL),
     "No moment of this log matches: longest free fall below 0.1 g: 0.00 s."),
    (record(FREEFALL), flight((1.0, 2.0, 0.1)),  # the log is shorter than the free-fall time
     "No moment of this log matches: longest free fall below 0.5 g: 0.98 s."),
    (record(ATTITUDE | FREEFALL), flight(LEVEL, TIPPED, LEVEL, FALLEN, LEVEL),
     "No moment of this log matches: tilt and free fall never together."),
    (record(ATTITUDE | FREEFALL), flight(LEVEL, FALLEN, LEVEL), "No moment of this log matches: tilt at most 2°."),
    (record(ATTITUDE), made_flight(UNKNOWN, 1.0), "No attitude: attitude trigger not judged."),
    (record(FREEFALL), made_flight(2.0, UNKNOWN), "No acceleration: free-fall trigger not judged."),
    (record(ATTITUDE), flight(LEVEL, TIPPED, is_judged=False), "No flight in this log."),
])  # fmt: skip
def test_why_there_is_no_moment(made: TriggerRecord, log: FlightLog, why: str) -> None:
    match = match_record(made, log)
    assert (match.moments, match.likeliest) == ((), None)
    assert match.why_none is not None
    assert match.why_none.in_english() == why


def said(made: TriggerRecord, log: FlightLog) -> str:
    moment = match_record(made, log).likeliest
    assert moment is not None
    return moment_message(moment, made).in_english()


def test_what_is_said_of_a_moment_is_a_proposal_with_what_speaks_against_it() -> None:
    tipped = flight(LEVEL, TIPPED, LEVEL)
    assert said(record(ATTITUDE), tipped) == (
        "Proposal: at 10.0 s the log shows 75°. The module was then powered on at -98 s of the log."
    )
    assert "powered on at 7 s of the log" in said(record(ATTITUDE, uptime_s=3), tipped)
    assert "powered on" not in said(record(ATTITUDE, uptime_s=65535), tipped)  # the counter has stopped


def test_a_moment_before_which_the_other_trigger_would_have_fired_comes_after_one_without() -> None:
    log = flight(LEVEL, (2.0, 75.0, 0.1), LEVEL, FALLEN, LEVEL)
    match = match_record(record(FREEFALL), log)
    assert [(moment.firing.at_s, moment.unnamed_s) for moment in match.moments] == [(11.6, 10.0), (23.6, None)]
    assert match.likeliest is match.moments[1]
    against = moment_message(match.moments[0], record(FREEFALL)).in_english()
    assert against.endswith("At 10.0 s the other trigger was met; the record does not name it.")


def test_a_moment_that_depends_on_the_reading_of_the_rule_says_so() -> None:
    log = flight(LEVEL, (0.1, 75.0, 1.0), LEVEL)
    (moment,) = match_record(record(ATTITUDE), log).moments
    assert moment.readings == {RuleReading.DIRECT}
    assert said(record(ATTITUDE), log).endswith("Only if the rule is read so: angle at once, acceleration unfiltered.")


def test_a_record_that_fits_everywhere_is_not_listed_without_end() -> None:
    match = match_record(record(ATTITUDE), flight(*[(0.5, 2.0, 1.0), (0.5, 75.0, 1.0)] * 30))
    assert (len(match.moments), match.has_more) == (MAX_MOMENTS, True)
    match = match_record(record(ATTITUDE), flight(*[(0.5, 2.0, 1.0), (0.5, 75.0, 1.0)] * MAX_MOMENTS))
    assert (len(match.moments), match.has_more) == (MAX_MOMENTS, False)


def test_every_trigger_of_the_simulated_module_is_among_the_proposals_for_its_record() -> None:
    random = np.random.default_rng(31)
    count = 0
    for _ in range(FLIGHTS):
        memory = Memory(
            attitude_threshold=int(random.integers(40, 120)),
            freefall_acceleration=int(random.integers(1, 10)),
            freefall_time=int(random.integers(20, 120)),
        )
        fired, log = module_fires(memory, *sensed_flight(random))
        for (at_s, sources), data in zip(fired[-9:], list(memory.records)[-9:], strict=True):
            match = match_record(record_of(record_frame(data)), log)
            assert match.has_more or at_s in [
                moment.firing.at_s for moment in match.moments if RuleReading.DIRECT in moment.readings
            ], (at_s, sources)
            count += 1
    assert count > FLIGHTS / 2


def test_a_proposal_holds_in_any_flight() -> None:
    """In flights with gaps, unknown values and restarts: the log measures at the moment what the record names."""
    random = np.random.default_rng(32)
    count = 0
    for _ in range(FLIGHTS):
        log = random_flight(random)
        made = record(Source(int(random.choice([2, 8, 10]))), tilt=int(random.integers(20, 120)),
                      force=int(random.integers(1, 8)), fall=int(random.integers(0, 100)))  # fmt: skip
        match = match_record(made, log)
        assert (match.why_none is None) == bool(match.moments)
        for moment in match.moments:
            assert moment.firing.sources in (ATTITUDE, FREEFALL, ATTITUDE | FREEFALL)
            assert log.is_judged[np.searchsorted(log.time_s, moment.firing.at_s)]
            if made.sources == ("attitude",) and RuleReading.DIRECT in moment.readings:
                assert moment.firing.tilt_deg >= made.attitude_threshold_deg
            if made.sources == ("freefall",) and RuleReading.DIRECT in moment.readings:
                assert moment.firing.acceleration_g < made.freefall_acceleration_g
            count += 1
    assert count > FLIGHTS / 2
