"""Two different answers to one question, or to the same one later, end the conversation (rule 7)."""

import pytest

from protocol.catalogue import STATUS
from protocol.events import Answered, Ended, EndReason, OutcomeUnknown, Received
from protocol.frame import encode_reply
from protocol.messages import Reading
from tests.support.line.link_bench import BOOTS, STREAMED, Bench, named

THRESHOLD = named("attitude_threshold")
SETTINGS = ("light_threshold", "attitude_threshold", "freefall_acceleration", "freefall_time")
LATER_S = [0.0, 0.002, 0.5, 10.0]


@pytest.fixture
def bench() -> Bench:
    return Bench().begun()


def told(bench: Bench) -> list[tuple[str, int, int]]:
    """The setting and both values of each contradiction."""
    pairs = [ended.contradiction for ended in bench.taken(Ended) if ended.contradiction is not None]
    return [(before.command.name, before.raw, after.raw) for before, after in pairs]


@pytest.mark.parametrize("after_s", LATER_S)
@pytest.mark.parametrize("name", SETTINGS)
@pytest.mark.promise("f")
def test_a_second_answer_that_differs(bench: Bench, name: str, after_s: float) -> None:
    command = named(name)
    bench.ask(command.query())
    bench.hear(encode_reply(command.code, 60))
    bench.hear(encode_reply(command.code, 85), after_s=after_s)
    assert told(bench) == [(name, 60, 85)]
    assert bench.reasons == [EndReason.CONTRADICTED]


@pytest.mark.parametrize("after_s", LATER_S)
@pytest.mark.promise("f")
def test_a_second_boot_count_is_no_restart(bench: Bench, after_s: float) -> None:
    """Also where it is the next one: two modules answer."""
    bench.ask(BOOTS)
    bench.wait(0.01)
    bench.hear(encode_reply(0x23, 38), after_s=after_s)
    assert bench.reasons == [EndReason.CONTRADICTED]


@pytest.mark.parametrize("name", SETTINGS)
@pytest.mark.promise("f")
def test_an_answer_that_differs_from_the_last_one_is_nobodys(bench: Bench, name: str) -> None:
    command = named(name)
    for raw in (60, 85):
        bench.ask(command.query())
        bench.hear(encode_reply(command.code, raw))
    assert told(bench) == [(name, 60, 85)]
    assert len(bench.taken(Answered)) == 1, "the second one answers nothing"
    events = [type(event) for event in bench.events if isinstance(event, Ended | Received)]
    assert events[-2:] == [Ended, Received], "it is not of the conversation that it ends"


def test_the_same_twice_is_no_contradiction_but_told(bench: Bench) -> None:
    bench.ask(THRESHOLD.query())
    bench.hear(encode_reply(0x20, 60))
    assert not bench.link.told.is_answered_twice(bench.now)
    bench.hear(encode_reply(0x20, 60), after_s=0.5)
    assert bench.reasons == []
    assert bench.link.told.is_answered_twice(bench.now)
    bench.wait(5.1)
    assert not bench.link.told.is_answered_twice(bench.now)


@pytest.mark.parametrize("name", ["light", "charging", "cell_voltage", "active", "triggered"])
@pytest.mark.promise("f")
def test_what_drifts_is_no_contradiction_but_told(bench: Bench, name: str) -> None:
    code = named(name).code
    bench.answers.pop(named(name).query().encode(), None)
    bench.ask(named(name).query())
    bench.hear(encode_reply(code, 0))
    bench.hear(encode_reply(code, 1), after_s=0.05)
    assert bench.reasons == []
    assert bench.link.told.is_answered_twice(bench.now)


def test_a_late_answer_to_a_repeated_question_is_no_second_one(bench: Bench) -> None:
    bench.ask(named("light").query())
    bench.wait(0.12)
    for _ in range(3):
        bench.hear(encode_reply(0x14, 3), after_s=0.001)
    assert bench.sent(named("light").query()) == 3
    assert not bench.link.told.is_answered_twice(bench.now)


def test_neither_is_the_boot_count_that_was_asked_behind_a_set(bench: Bench) -> None:
    bench.ask(named("freefall_time").set(1.2))
    bench.is_there = False
    bench.wait(0.24)
    bench.is_there = True
    bench.hear(encode_reply(0x22, 120))
    for _ in range(bench.sent(BOOTS)):
        bench.hear(encode_reply(0x23, 37), after_s=0.01)
    assert not bench.link.told.is_answered_twice(bench.now)


def test_streamed_reports_are_none(bench: Bench) -> None:
    bench.ask(STATUS.query())
    bench.hear(STREAMED)
    bench.hear(STREAMED, after_s=0.1)
    assert bench.reasons == []
    assert not bench.link.told.is_answered_twice(bench.now)


def test_after_a_set_the_new_value_is_none_and_neither_is_a_copy_of_the_acknowledgement(bench: Bench) -> None:
    command = named("freefall_time")
    bench.ask(command.query())
    bench.hear(encode_reply(0x22, 160))
    bench.ask(command.set(1.2))
    bench.hear(encode_reply(0x22, 1), after_s=0.05)  # E2
    bench.hear(encode_reply(0x22, 1), after_s=1.0)
    bench.ask(command.query())
    bench.hear(encode_reply(0x22, 120), after_s=0.02)
    assert bench.taken(Answered)[-1].messages == (Reading(command, 120),)
    assert bench.reasons == []
    bench.wait(6.0)
    bench.ask(command.query())
    bench.hear(encode_reply(0x22, 160))
    assert told(bench) == [("freefall_time", 120, 160)], "it changed by itself, or it is another module"


def test_what_was_told_before_does_not_count_in_the_next_conversation(bench: Bench) -> None:
    bench.ask(THRESHOLD.query())
    bench.hear(encode_reply(0x20, 60))
    bench.events += bench.link.end(EndReason.ANOTHER, bench.now)
    bench.wait(0.5)
    bench.events.clear()
    bench.ask(THRESHOLD.query())
    bench.hear(encode_reply(0x20, 85))
    assert bench.reasons == []
    assert len(bench.taken(Answered)) == 1


@pytest.mark.promise("f")
def test_what_waits_behind_the_fence_is_not_sent(bench: Bench) -> None:
    activate = named("activation").set(True)
    bench.is_there = False
    assert bench.begin_to_ask(activate, is_deliberate=True, is_fenced=True) == BOOTS.encode()
    bench.hear(encode_reply(0x23, 12))
    bench.wait(3.0)
    assert bench.reasons == [EndReason.CONTRADICTED]
    assert bench.sent(activate) == 0


@pytest.mark.promise("f")
def test_a_set_that_has_left_ends_with_the_conversation(bench: Bench) -> None:
    bench.ask(named("activation").set(True), is_deliberate=True)
    bench.is_there = False
    bench.hear(encode_reply(0x23, 12), after_s=0.1)
    assert bench.reasons == [EndReason.CONTRADICTED]
    assert bench.link.is_idle or bench.link.is_own
    assert len(bench.taken(OutcomeUnknown)) == 1
