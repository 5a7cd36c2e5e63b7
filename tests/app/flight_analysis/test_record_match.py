"""Where in a flight log a trigger record may have been made."""

import numpy as np
import pytest
from numpy.typing import NDArray

from app.flight_analysis.record_match import MAX_MOMENTS, match_record, measured_text, moment_message, record_limits
from app.flight_logs.flight_log import FlightLog
from app.flight_logs.module_view import RuleReading
from app.simulator.memory import Memory, record_frame
from app.trigger_records.history import record_of
from protocol.messages import Source, TriggerRecord
from tests.app.flight_analysis.test_simulated_module import module_fires, random_flight
from tests.support.flights.made_flights import made_flight
from tests.support.flights.made_flights import random_flight as random_log

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
    assert [one.firing.at_s for one in match.moments] == pytest.approx(moments_s)
    assert [measured_text(one.firing) for one in match.moments] == measured
    assert match.likeliest is match.moments[0]
    assert match.limits == record_limits(made)


@pytest.mark.parametrize(("made", "log", "why"), [
    (record(SERIAL), flight(LEVEL, TIPPED), "A flight log does not show this cause: fired by serial."),
    (record(PWM), flight(LEVEL, TIPPED), "A flight log does not show this cause: fired by PWM."),
    (record(SERIAL | PWM), flight(LEVEL, TIPPED),
     "A flight log does not show this cause: fired by serial + fired by PWM."),
    (record(Source(0)), flight(LEVEL, TIPPED), "A flight log does not show this cause: no cause stated."),
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
    (record(ATTITUDE), made_flight(UNKNOWN, 1.0), "The log has no attitude."),
    (record(FREEFALL), made_flight(2.0, UNKNOWN), "The log has no acceleration."),
    (record(ATTITUDE), flight(LEVEL, TIPPED, is_judged=False), "Nothing in this log counts as flight."),
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
        "Proposal: at 10.0 s the log shows 75°. The module was then powered on 98 s before the start of the log."
    )
    assert "powered on 7 s after the start of the log" in said(record(ATTITUDE, uptime_s=3), tipped)
    assert "powered on" not in said(record(ATTITUDE, uptime_s=65535), tipped)  # the counter has stopped


def test_a_moment_before_which_the_other_trigger_would_have_fired_comes_after_one_without() -> None:
    log = flight(LEVEL, (2.0, 75.0, 0.1), LEVEL, FALLEN, LEVEL)
    match = match_record(record(FREEFALL), log)
    assert [(one.firing.at_s, one.unnamed_s) for one in match.moments] == [(11.6, 10.0), (23.6, None)]
    assert match.likeliest is match.moments[1]
    against = moment_message(match.moments[0], record(FREEFALL)).in_english()
    assert against.endswith("Against it: at 10.0 s the other trigger was met; the record does not name it.")


def test_a_moment_that_depends_on_the_reading_of_the_rule_says_so() -> None:
    log = flight(LEVEL, (0.1, 75.0, 1.0), LEVEL)
    (moment,) = match_record(record(ATTITUDE), log).moments
    assert moment.readings == {RuleReading.DIRECT}
    assert said(record(ATTITUDE), log).endswith("Only if the rule is read so: angle at once, acceleration unfiltered.")


def test_a_record_that_fits_everywhere_is_not_listed_without_end() -> None:
    match = match_record(record(ATTITUDE), flight(*[(0.5, 2.0, 1.0), (0.5, 75.0, 1.0)] * 30))
    assert (len(match.moments), match.has_more) == (MAX_MOMENTS, True)


def test_every_trigger_of_the_simulated_module_is_among_the_proposals_for_its_record() -> None:
    random = np.random.default_rng(31)
    count = 0
    for _ in range(FLIGHTS):
        memory = Memory(
            attitude_threshold=int(random.integers(40, 120)),
            freefall_acceleration=int(random.integers(1, 10)),
            freefall_time=int(random.integers(20, 120)),
        )
        fired, log = module_fires(memory, *random_flight(random))
        for (at_s, sources), data in zip(fired[-9:], list(memory.records)[-9:], strict=True):
            match = match_record(record_of(record_frame(data)), log)
            assert match.has_more or at_s in [
                one.firing.at_s for one in match.moments if RuleReading.DIRECT in one.readings
            ], (at_s, sources)
            count += 1
    assert count > FLIGHTS / 2


def test_a_proposal_holds_in_any_flight() -> None:
    """In flights with gaps, unknown values and restarts: the log measures at the moment what the record names."""
    random = np.random.default_rng(32)
    count = 0
    for _ in range(FLIGHTS):
        log = random_log(random)
        made = record(Source(int(random.choice([2, 8, 10]))), tilt=int(random.integers(20, 120)),
                      force=int(random.integers(1, 8)), fall=int(random.integers(0, 100)))  # fmt: skip
        match = match_record(made, log)
        assert (match.why_none is None) == bool(match.moments)
        for one in match.moments:
            assert one.firing.sources in (ATTITUDE, FREEFALL, ATTITUDE | FREEFALL)
            assert log.is_judged[np.searchsorted(log.time_s, one.firing.at_s)]
            if made.sources == ("attitude",) and RuleReading.DIRECT in one.readings:
                assert one.firing.tilt_deg >= made.attitude_threshold_deg
            if made.sources == ("freefall",) and RuleReading.DIRECT in one.readings:
                assert one.firing.acceleration_g < made.freefall_acceleration_g
            count += 1
    assert count > FLIGHTS / 2
