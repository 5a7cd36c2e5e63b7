"""The pause before a request, for modules that do not listen at once, or not while they send."""

import pytest

from protocol.catalogue import ACTIVATION, BY_NAME, SERIAL_OUTPUT, SETTINGS
from protocol.events import Sent, Unanswered
from protocol.timing import CLEAR_S, LOST_IN_A_ROW, MAX_S, ONCE_S, QUESTION_S, STREAM_LATE_S, Gap
from tests.support.line.link_bench import STREAMED, Bench, named

SET = BY_NAME["freefall_time"].set(1.2)
QUESTION = BY_NAME["freefall_time"].query()


@pytest.fixture
def bench() -> Bench:
    return Bench().begun()


@pytest.mark.promise("k")
def test_lock_leaves_at_once_and_a_set_does_not(bench: Bench) -> None:
    bench.ask(named("active").query())
    bench.wait(0.003)
    answered_at = bench.now
    assert bench.begin_to_ask(SET) == b""
    assert not bench.has_left
    assert bench.link.next_deadline(bench.now) == pytest.approx(answered_at + ONCE_S)
    assert bench.link.abandon(bench.now) == [Unanswered(SET, 0, 0.0, bench.now)]
    (sent,) = bench.link.ask(ACTIVATION.set(False), bench.now)
    assert isinstance(sent, Sent)


def test_a_set_leaves_directly_after_a_streamed_report(bench: Bench) -> None:
    for _ in range(20):
        bench.hear(STREAMED, after_s=0.05)
    bench.wait(0.048)
    assert bench.begin_to_ask(SET) == b""
    bench.hear(STREAMED, after_s=0.004)
    assert bench.sent_at(SET) == [bench.now]


def test_nothing_is_held_back_for_longer_than_the_longest_pause(bench: Bench) -> None:
    bench.hear(bytes.fromhex("41 75 14 01 03 18"))
    asked_at = bench.now
    bench.events += bench.link.ask(SERIAL_OUTPUT.set(True), bench.now)
    while not bench.sent(SERIAL_OUTPUT.set(True)):
        bench.now += 0.01
        bench.events += bench.link.receive(bytes.fromhex("41 75 14 01 03 18"), bench.now)
        bench.events += bench.link.tick(bench.now)
    assert bench.now - asked_at == pytest.approx(MAX_S, abs=0.011)


def ask(gap: Gap, *, attempts: int) -> None:
    for attempt in range(attempts):
        gap.sent(is_repeated=attempt > 0, now=0.0)
    gap.answered()


@pytest.mark.promise("k")
def test_the_pause_begins_where_quick_questions_are_lost_one_after_the_other() -> None:
    gap = Gap()
    for _ in range(LOST_IN_A_ROW - 1):
        ask(gap, attempts=2)
    ask(gap, attempts=1)
    for _ in range(LOST_IN_A_ROW - 1):
        ask(gap, attempts=3)
    assert gap.question_s == 0.0
    ask(gap, attempts=2)
    assert gap.question_s == QUESTION_S
    ask(gap, attempts=1)
    gap.on_spoken(1.0)
    assert gap.due(QUESTION, 1.0, is_repeated=False, now=1.0) == 1.0 + QUESTION_S, "it stays"


def test_what_is_never_answered_teaches_nothing(bench: Bench) -> None:
    for _ in range(5):
        bench.ask(named("light").query())
        bench.wait(1.0)
    assert bench.link.gap.question_s == 0.0


def test_every_setting_waits_for_a_quiet_line() -> None:
    for command in SETTINGS:
        assert command.write is not None
        gap = Gap()
        gap.on_spoken(1.0)
        request = command.set(command.write.decode(min(command.write.allowed)))
        assert gap.due(request, 1.0, is_repeated=False, now=1.0) == 1.0 + ONCE_S
    assert Gap().due(QUESTION, 1.0, is_repeated=False, now=1.0) == 1.0


def streaming(*times_s: float) -> Gap:
    gap = Gap()
    for time_s in times_s:
        gap.on_streamed(time_s)
    return gap


@pytest.mark.parametrize(
    ("times_s", "asked_at", "due_at"),
    [
        ([], 2.0, 2.0),
        ([1.0], 2.0, 2.0),
        ([0.0, 1.0], 1.0, 1.0),  # directly after a report
        ([0.0, 1.0], 2.0 - CLEAR_S - 0.001, 2.0 - CLEAR_S - 0.001),
        ([0.0, 1.0], 2.0 - CLEAR_S, 2.0 + STREAM_LATE_S),
        ([0.0, 1.0], 2.0 + STREAM_LATE_S + 0.001, 2.0 + STREAM_LATE_S + 0.001),  # the report is missing
        ([0.0, 1.125], 2.125, 2.125),  # a pause of more than a second: nothing is due
        ([0.0, 1.0, 2.125], 3.125, 3.125),
        ([0.0, 0.5, 0.5 + 2**-12], 1.0, 1.0 + 2**-12 + STREAM_LATE_S),  # two reports in one read
        ([0.0, 0.5, 1.5], 2.0, 2.0 + STREAM_LATE_S),  # the shortest interval counts
    ],
)
@pytest.mark.promise("k")
def test_a_set_leaves_between_two_streamed_reports(times_s: list[float], asked_at: float, due_at: float) -> None:
    gap = streaming(*times_s)
    assert gap.due(SET, asked_at, is_repeated=False, now=asked_at) == pytest.approx(due_at)
    assert gap.due(QUESTION, asked_at, is_repeated=True, now=asked_at) == pytest.approx(due_at)
    assert gap.due(QUESTION, asked_at, is_repeated=False, now=asked_at) == asked_at
    assert gap.due(ACTIVATION.set(False), asked_at, is_repeated=True, now=asked_at) == asked_at
