"""The pause before a request, for modules that do not listen at once, or not while they send."""

import pytest

from protocol.catalogue import ACTIVATION, BY_NAME, SETTINGS
from protocol.events import Sent, Unanswered
from protocol.timing import LOST_IN_A_ROW, ONCE_S, QUESTION_S, Gap
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


def test_every_setting_waits_for_a_quiet_line() -> None:
    for command in SETTINGS:
        assert command.write is not None
        gap = Gap()
        gap.on_spoken(1.0)
        request = command.set(command.write.decode(min(command.write.allowed)))
        assert gap.due(request, 1.0, is_repeated=False, now=1.0) == 1.0 + ONCE_S
    assert Gap().due(QUESTION, 1.0, is_repeated=False, now=1.0) == 1.0
