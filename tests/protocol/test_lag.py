"""What the link measures: lag, round trips, counts."""

from math import inf

import pytest

from protocol.catalogue import BY_NAME, HEARTBEAT, SERIAL_OUTPUT, STATUS, TRIGGER_RECORDS
from protocol.events import Answered, Received, Restarted, Role, Sent
from protocol.frame import encode_reply
from protocol.lag import MAX_S, STREAM_SHOWS_S, Lag
from protocol.messages import Status
from protocol.round_trips import ENOUGH_SAMPLES, MAX_SAMPLES, RoundTrips, Timing
from tests.support.line.link_bench import PULSE, RECORD, STREAMED, Bench, named

LIGHT = BY_NAME["light"].query()
CHARGING = BY_NAME["charging"].query()
STATE = STATUS.query()


@pytest.mark.parametrize(("passed_s", "is_answerable"), [(MAX_S, True), (MAX_S + 0.125, False)])
def test_a_question_is_answerable_for_ten_seconds(passed_s: float, is_answerable: bool) -> None:
    lag = Lag(0.0)
    lag.ask(LIGHT, 1.0)
    lag.ask(CHARGING, 1.0 + passed_s)
    assert MAX_S == 10.0
    assert lag.asked_at(LIGHT) == (1.0 if is_answerable else -inf)


@pytest.mark.parametrize(("overdue_s", "lag_s"), [(0.25, 0.5), (MAX_S, MAX_S), (MAX_S + 0.125, 0.5)])
def test_an_overdue_answer_counts_for_ten_seconds(overdue_s: float, lag_s: float) -> None:
    lag = Lag(0.0)
    assert lag.seconds(0.0) is None
    lag.ask(LIGHT, 1.0)
    lag.answer(LIGHT, 1.5)
    assert lag.seconds(2.0) == 0.5
    lag.ask(CHARGING, 2.0)
    assert lag.seconds(5.0) == 0.5, "the module may not know this question"
    lag.ask(LIGHT, 3.0)
    assert lag.seconds(3.0 + overdue_s) == 0.5, "nothing came since: it is silent, not late"
    lag.heard_at = 3.125
    assert lag.seconds(3.0 + overdue_s) == lag_s


@pytest.mark.parametrize(("passed_s", "may_be"), [(STREAM_SHOWS_S, True), (STREAM_SHOWS_S + 0.125, False)])
def test_a_status_may_be_streamed_for_three_seconds_after_an_unasked_frame(passed_s: float, may_be: bool) -> None:
    lag = Lag(1.0)
    assert STREAM_SHOWS_S == 3.0
    assert lag.may_be_streamed(STATE, 1.0 + passed_s) is may_be
    assert not lag.may_be_streamed(LIGHT, 1.0 + passed_s)
    lag.on_unsolicited(11.0)
    assert lag.may_be_streamed(STATE, 11.0 + passed_s) is may_be
    lag.ask(LIGHT, 20.0)
    assert not lag.may_be_streamed(STATE, 20.0)
    lag.ask(SERIAL_OUTPUT.set(True), 21.0)
    assert lag.may_be_streamed(STATE, 21.0 + passed_s) is may_be


def test_what_arrives_after_an_answer_was_sent_after_its_question() -> None:
    lag = Lag(0.0)
    assert lag.sent_after == -inf
    lag.ask(LIGHT, 5.0)
    lag.ask(STATE, 6.0)
    lag.ask(CHARGING, 7.0)
    assert lag.answer_sent_after(STATE, 8.0) == 6.0
    lag.answer(LIGHT, 8.0)
    assert (lag.sent_after, lag.asked_at(LIGHT), lag.asked_at(CHARGING)) == (5.0, -inf, 7.0)
    lag.answer(STATE, 8.0)
    assert (lag.sent_after, lag.seconds(8.0)) == (5.0, 3.0)
    lag.answer(LIGHT, 9.0)
    assert (lag.sent_after, lag.seconds(9.0)) == (5.0, 3.0), "nothing was asked"
    lag.answer(CHARGING, 9.0)
    assert lag.sent_after == 7.0


def test_a_heartbeat_measures_and_proves_nothing() -> None:
    lag = Lag(0.0)
    lag.ask(HEARTBEAT.query(), 5.0)
    lag.answer(HEARTBEAT.query(), 5.25)
    assert (lag.sent_after, lag.seconds(6.0)) == (-inf, 0.25)


def test_a_status_that_may_be_streamed_is_as_new_as_what_was_answered_before() -> None:
    lag = Lag(5.0)
    lag.ask(STATE, 6.0)
    assert lag.answer_sent_after(STATE, 6.5) == -inf
    lag.ask(LIGHT, 6.5)
    lag.answer(LIGHT, 6.75)
    assert lag.answer_sent_after(STATE, 7.0) == 6.5
    lag.ask(STATE, 10.0)
    assert lag.answer_sent_after(STATE, 10.25) == 10.0


# How long the answer to a question is waited for


TIMING = Timing(answer_s=1.0, shortest_wait_s=0.125, attempts=4)


def measured(*samples_s: float) -> RoundTrips:
    round_trips = RoundTrips()
    for sample_s in samples_s:
        round_trips.add(sample_s)
    return round_trips


def test_the_vendors_numbers() -> None:
    timing = Timing()
    assert (timing.answer_s, timing.attempts) == (1.0, 3)
    assert timing.late_s == timing.attempts * timing.answer_s
    assert 10.0 <= timing.heartbeat_every_s <= 30.0
    assert timing.doubled_s < 0.05 < timing.restart_s < 1.0, "a restart sends two heartbeats 50 ms apart"
    assert timing.drain_s + timing.probe_after_s < timing.shortest_wait_s < timing.quiet_s < timing.records_quiet_s


@pytest.mark.parametrize(
    ("samples_s", "waits_s"),
    [
        ([], (1.0, 1.0, 1.0, 1.0)),
        ([0.0625] * (ENOUGH_SAMPLES - 1), (0.5, 1.0, 1.0, 1.0)),
        ([0.0625] * ENOUGH_SAMPLES, (0.25, 0.5, 1.0, 1.0)),
        ([0.0] * ENOUGH_SAMPLES, (0.125, 0.25, 0.5, 1.0)),
        ([2.0] * ENOUGH_SAMPLES, (1.0, 1.0, 1.0, 1.0)),
        ([0.0] * 95 + [0.0625] * 5, (0.25, 0.5, 1.0, 1.0)),
        ([0.0] * 96 + [0.0625] * 4, (0.125, 0.25, 0.5, 1.0)),
    ],
)
def test_the_waits_grow_from_the_measured_round_trips(samples_s: list[float], waits_s: tuple[float, ...]) -> None:
    assert measured(*samples_s).waits_s(TIMING) == waits_s


def test_quantiles_of_the_latest_samples() -> None:
    assert measured().quantile_s(0.0) is None
    three = measured(3.0, 1.0, 2.0)
    assert (three.quantile_s(0.0), three.quantile_s(0.5)) == (1.0, 2.0)
    three.add(0.5)
    assert [three.quantile_s(share) for share in (0.0, 0.5, 0.75)] == [0.5, 2.0, 3.0]
    assert measured(1.0, *[3.0] * (MAX_SAMPLES - 1), 2.0).quantile_s(0.0) == 2.0, "the oldest is forgotten"


# What the link tells its measurements: how late frames are, and which pauses the module needs


SOUND = named("attitude_threshold")


@pytest.fixture
def bench() -> Bench:
    bench = Bench()
    bench.warm_up(10)  # for longer than it takes to know that nothing streams
    return bench


@pytest.mark.parametrize(("unasked", "is_timed"), [((), True), ((STREAMED,), False), ((PULSE,), False)])
def test_a_status_is_timed_only_where_none_streams(unasked: tuple[bytes, ...], is_timed: bool, bench: Bench) -> None:
    bench.hear(*unasked)
    bench.ask(SOUND.query())
    bench.hear(encode_reply(SOUND.code, 60), after_s=0.02)
    bench.ask(STATUS.query())
    asked_at = bench.now
    bench.hear(STREAMED, after_s=0.01)
    *_, answered = bench.taken(Answered)
    assert answered.round_trip_s == (pytest.approx(0.01) if is_timed else None)
    *_, status = bench.taken(Received)
    assert (status.sent_after == asked_at) is is_timed


def test_a_late_status_was_sent_after_what_was_answered_before(bench: Bench) -> None:
    bench.ask(SOUND.query())
    asked_at = bench.now
    bench.hear(encode_reply(SOUND.code, 60))
    bench.ask(STATUS.query(), attempts=1)
    bench.hear(STREAMED, after_s=1.5)
    *_, late = bench.taken(Received)
    assert (late.role, late.sent_after) == (Role.LATE, asked_at)


def test_what_follows_a_late_answer_was_sent_after_its_question(bench: Bench) -> None:
    bench.ask(SOUND.query(), attempts=1)
    asked_at = bench.now
    bench.hear(encode_reply(SOUND.code, 60), after_s=1.5)
    assert bench.link.lag.sent_after == asked_at


def test_a_status_that_follows_a_copy_of_the_one_before_is_an_answer_and_no_stream(bench: Bench) -> None:
    """The copy was taken for the answer to the second question."""
    for _ in range(2):
        bench.ask(STATUS.query())
        bench.hear(STREAMED, after_s=0.02)
    bench.hear(Status(8, 1.0, False, True).encode(), after_s=0.02)
    roles = [one.role for one in bench.taken(Received)]
    assert roles[-3:] == [Role.ANSWER, Role.ANSWER, Role.LATE]


def test_what_follows_a_record_was_sent_after_its_question(bench: Bench) -> None:
    bench.ask(TRIGGER_RECORDS.query())
    asked_at = bench.now
    bench.hear(RECORD)
    assert bench.link.lag.sent_after == asked_at


def test_a_question_is_not_repeated_directly_before_a_streamed_report(bench: Bench) -> None:
    """A module on a half-duplex line would not hear it."""
    for _ in range(4):
        bench.hear(STREAMED, after_s=0.02)
    bench.ask(SOUND.query(), waits_s=(1.0, 1.0))
    asked_at = bench.now
    for _ in range(51):
        bench.hear(STREAMED, after_s=1.032 / 51)  # the last one comes 2 ms after it could be repeated
    _, repeated = bench.taken(Sent)
    assert repeated.at - asked_at == pytest.approx(1.032)


def test_each_status_is_counted_from_its_own_question(bench: Bench) -> None:
    for _ in range(2):
        bench.ask(STATUS.query())
        asked_at = bench.now
        bench.hear(STREAMED, after_s=0.01)
        bench.wait(0.5)
    *_, status = bench.taken(Received)
    assert status.sent_after == asked_at


def test_a_question_is_asked_at_once_between_streamed_reports(bench: Bench) -> None:
    for _ in range(4):
        bench.hear(STREAMED, after_s=0.02)
    bench.wait(0.018)
    assert bench.link.ask(SOUND.query(), bench.now)
    assert bench.link.take_outgoing() == SOUND.query().encode()


@pytest.mark.parametrize("slow", [(), (19,), (4, 12, 19)])
def test_an_answer_that_may_be_a_copy_of_the_one_before_is_not_overdue(slow: tuple[int, ...], bench: Bench) -> None:
    """As with the heartbeats of a pre-flight check, after which only the status is asked for."""
    for number in range(20):
        bench.ask(HEARTBEAT.query())
        bench.hear(PULSE, after_s=0.03 if number in slow else 0.004)
    for _ in range(20):
        bench.ask(STATUS.query())
        bench.hear(STREAMED, after_s=0.1)
    lag_s = bench.link.lag.seconds(bench.now)
    assert lag_s is not None
    assert lag_s < 0.2
    assert bench.link.lag.asked_at(HEARTBEAT.query()) < bench.now - 1, "it may still come"


def test_heartbeats_that_each_answer_the_next_question_are_no_restart(bench: Bench) -> None:
    """On a line that became late the reply to each comes while the next one is in flight, and one is left over."""
    bench.ask(HEARTBEAT.query(), waits_s=(0.5,))
    bench.wait(0.5)
    for _ in range(8):  # for longer than a late reply is waited for
        bench.ask(HEARTBEAT.query(), waits_s=(0.5,))
        bench.hear(PULSE, after_s=0.49)
    bench.hear(PULSE, after_s=0.49)
    bench.wait(1.0)
    roles = [one.role for one in bench.taken(Received)]
    assert roles[-1] is Role.LATE
    assert bench.taken(Restarted) == []
