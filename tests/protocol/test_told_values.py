"""Two different answers to one question, or to the same one later, end the conversation (rule 7)."""

import pytest

from protocol.events import Answered, Ended, EndReason, Received
from protocol.frame import encode_reply
from protocol.messages import Reading
from tests.support.line.link_bench import BOOTS, Bench, named

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
