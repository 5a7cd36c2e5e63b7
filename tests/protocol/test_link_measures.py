"""What the link tells its measurements: how late frames are, and which pauses the module needs."""

import pytest

from protocol.catalogue import HEARTBEAT, STATUS, TRIGGER_RECORDS
from protocol.events import Answered, Received, Restarted, Role, Sent
from protocol.frame import encode_reply
from protocol.messages import Status
from tests.support.line.link_bench import PULSE, RECORD, STREAMED, Bench, named

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
    assert isinstance(answered, Answered)
    assert answered.round_trip_s == (pytest.approx(0.01) if is_timed else None)
    *_, status = bench.taken(Received)
    assert isinstance(status, Received)
    assert (status.sent_after == asked_at) is is_timed


def test_a_late_status_was_sent_after_what_was_answered_before(bench: Bench) -> None:
    bench.ask(SOUND.query())
    asked_at = bench.now
    bench.hear(encode_reply(SOUND.code, 60))
    bench.ask(STATUS.query(), attempts=1)
    bench.hear(STREAMED, after_s=1.5)
    *_, late = bench.taken(Received)
    assert isinstance(late, Received)
    assert (late.role, late.sent_after) == (Role.LATE, asked_at)


def test_a_status_that_follows_a_copy_of_the_one_before_is_an_answer_and_no_stream(bench: Bench) -> None:
    """The copy was taken for the answer to the second question."""
    for _ in range(2):
        bench.ask(STATUS.query())
        bench.hear(STREAMED, after_s=0.02)
    bench.hear(Status(8, 1.0, False, True).encode(), after_s=0.02)
    roles = [one.role for one in bench.taken(Received) if isinstance(one, Received)]
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
    assert isinstance(repeated, Sent)
    assert repeated.at - asked_at == pytest.approx(1.032)


def test_each_status_is_counted_from_its_own_question(bench: Bench) -> None:
    for _ in range(2):
        bench.ask(STATUS.query())
        asked_at = bench.now
        bench.hear(STREAMED, after_s=0.01)
        bench.wait(0.5)
    *_, status = bench.taken(Received)
    assert isinstance(status, Received)
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
    roles = [one.role for one in bench.taken(Received) if isinstance(one, Received)]
    assert roles[-1] is Role.LATE
    assert bench.taken(Restarted) == []
