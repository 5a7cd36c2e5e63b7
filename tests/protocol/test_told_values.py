"""Two different answers to one question, or to the same one later, are told; nothing that waits is sent then."""

import pytest

from protocol.catalogue import STATUS
from protocol.events import Answered, Contradicted, OutcomeUnknown, Sent
from protocol.frame import encode_reply
from tests.support.line.link_bench import PULSE, STREAMED, Bench, named

THRESHOLD, BOOTS = named("attitude_threshold"), named("boot_count")
LASTING = ("boot_count", "light_threshold", "attitude_threshold", "freefall_acceleration", "freefall_time")


@pytest.fixture
def bench() -> Bench:
    bench = Bench()
    bench.warm_up()
    return bench


def told(bench: Bench) -> list[tuple[str, int, int]]:
    return [(event.before.command.name, event.before.raw, event.after.raw) for event in bench.taken(Contradicted)]


@pytest.mark.parametrize("after_s", [0.0, 0.002, 0.5, 10.0])
@pytest.mark.parametrize("name", LASTING)
@pytest.mark.promise("f")
def test_a_second_answer_that_differs(bench: Bench, name: str, after_s: float) -> None:
    command = named(name)
    bench.ask(command.query())
    bench.hear(encode_reply(command.code, 60))
    bench.hear(encode_reply(command.code, 85), after_s=after_s)
    assert told(bench) == [(name, 60, 85)]


@pytest.mark.parametrize("name", LASTING[1:])
def test_an_answer_that_differs_from_the_last_one(bench: Bench, name: str) -> None:
    command = named(name)
    for raw in (60, 85):
        bench.ask(command.query())
        bench.hear(encode_reply(command.code, raw))
        bench.wait(1.0)
    assert told(bench) == [(name, 60, 85)]
    assert len(bench.taken(Answered)) == 1, "the second one answers nothing"


def test_another_boot_count_as_an_answer_is_a_restart_and_no_contradiction(bench: Bench) -> None:
    for raw in (37, 38):
        bench.ask(BOOTS.query())
        bench.hear(encode_reply(0x23, raw))
    assert told(bench) == []


def test_the_same_twice_is_none(bench: Bench) -> None:
    bench.ask(THRESHOLD.query())
    bench.hear(encode_reply(0x20, 60))
    bench.hear(encode_reply(0x20, 60), after_s=0.5)
    assert told(bench) == []


def test_what_drifts_is_none(bench: Bench) -> None:
    for name in ("light", "cell_voltage", "charging", "active", "triggered"):
        code = named(name).code
        bench.ask(named(name).query())
        bench.hear(encode_reply(code, 0))
        bench.hear(encode_reply(code, 1), after_s=0.05)
        bench.wait(0.1)
    bench.ask(STATUS.query())
    bench.hear(STREAMED, after_s=0.01)
    bench.hear(PULSE, after_s=0.1)
    assert told(bench) == []


def test_after_a_set_the_new_value_is_none_and_neither_is_a_copy_of_the_acknowledgement(bench: Bench) -> None:
    command = named("freefall_time")
    bench.ask(command.query())
    bench.hear(encode_reply(0x22, 160))
    bench.ask(command.set(1.2))
    bench.hear(PULSE)  # the fence
    bench.hear(encode_reply(0x22, 1), after_s=0.1)  # E2
    bench.hear(encode_reply(0x22, 1), after_s=1.0)
    bench.ask(command.query())
    bench.hear(PULSE, after_s=0.05)
    bench.hear(encode_reply(0x22, 120))
    assert told(bench) == []
    bench.wait(6.0)
    bench.ask(command.query())
    bench.hear(encode_reply(0x22, 160))
    assert told(bench) == [("freefall_time", 120, 160)]


@pytest.mark.parametrize("how", ["restart", "silence"])
def test_what_was_told_before_the_conversation_broke_is_forgotten(bench: Bench, how: str) -> None:
    bench.ask(THRESHOLD.query())
    bench.hear(encode_reply(0x20, 60))
    if how == "restart":
        bench.hear(PULSE, after_s=1.0)
        bench.hear(PULSE, after_s=0.05)
    else:
        bench.ask(named("light").query(), attempts=1)
        bench.wait(0.5)
        bench.hear(PULSE)
    bench.ask(THRESHOLD.query())
    bench.wait(0.001)
    bench.hear(encode_reply(0x20, 85))
    assert told(bench) == []


@pytest.mark.promise("f")
def test_what_waits_behind_the_fence_is_not_sent(bench: Bench) -> None:
    bench.ask(BOOTS.query())
    bench.hear(encode_reply(0x23, 37))
    activate = named("activation").set(True)
    bench.ask(activate, is_deliberate=True, is_fenced=True)
    for raw in (encode_reply(0x33, 0), encode_reply(0x23, 12)):  # the fence's, and the second module's
        bench.wait(0.01)
        bench.events += bench.link.receive(raw, bench.now)
    bench.wait(3.0)
    assert told(bench) == [("boot_count", 37, 12)]
    assert activate not in [event.request for event in bench.taken(Sent)]
    assert bench.link.is_idle


def test_a_set_that_has_left_is_unknown(bench: Bench) -> None:
    bench.ask(BOOTS.query())
    bench.hear(encode_reply(0x23, 37))
    bench.wait(0.1)
    bench.ask(named("activation").set(True), is_deliberate=True)
    bench.wait(0.1)
    bench.hear(encode_reply(0x23, 12))
    assert [event.request.command.name for event in bench.taken(OutcomeUnknown)] == ["activation"]
    assert told(bench) == [("boot_count", 37, 12)]
