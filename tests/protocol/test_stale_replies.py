"""Late and doubled replies, and the fence: nothing that was asked before is taken for an answer."""

import pytest

from protocol.catalogue import TRIGGER_RECORDS
from protocol.events import Answered, Role
from protocol.frame import encode_reply
from protocol.messages import Reading
from protocol.stale_replies import FENCES
from tests.support.line.link_bench import BOOTS, RECORD, TRAP, Bench, named

TIME, THRESHOLD, VOLTAGE = named("freefall_time"), named("attitude_threshold"), named("cell_voltage")
FENCE = BOOTS.encode()
ANY_FENCE = {fence.encode() for fence in FENCES}


@pytest.fixture
def bench() -> Bench:
    return Bench().begun()


def last_answer(bench: Bench) -> object:
    return bench.taken(Answered)[-1].messages[0]


def test_e03_a_voltage_asked_after_records_waits_behind_a_fence(bench: Bench) -> None:
    bench.ask(TRIGGER_RECORDS.query())
    bench.hear(RECORD)
    bench.wait(0.5)
    assert bench.begin_to_ask(VOLTAGE.query()) in ANY_FENCE
    bench.hear(TRAP, after_s=0.001)  # a record that took its time
    bench.wait(0.01)
    assert bench.sent(VOLTAGE.query()) == 1
    bench.hear(encode_reply(0x35, 0xC8))
    voltage = last_answer(bench)
    assert isinstance(voltage, Reading)
    assert voltage.value == 4.0


@pytest.mark.promise("f")
def test_a_read_back_is_never_the_late_acknowledgement(bench: Bench) -> None:
    """A module that echoes late and does not keep: its echo must not pass for the value read back."""
    bench.ask(TIME.set(1.8))
    bench.wait(0.3)
    assert bench.begin_to_ask(TIME.query()) in ANY_FENCE
    bench.hear(encode_reply(0x22, 180), after_s=0.001)
    bench.wait(0.01)
    bench.hear(encode_reply(0x22, 160))
    assert last_answer(bench) == Reading(TIME, 160)


@pytest.mark.promise("f")
def test_a_doubled_acknowledgement_is_not_the_read_back(bench: Bench) -> None:
    bench.ask(TIME.set(1.8))
    bench.hear(encode_reply(0x22, 180))
    assert bench.begin_to_ask(TIME.query()) == FENCE
    bench.hear(encode_reply(0x22, 180), after_s=0.001)
    bench.wait(0.01)
    bench.hear(encode_reply(0x22, 160))
    assert last_answer(bench) == Reading(TIME, 160)


def test_a_fence_without_answer_sends_nothing_else(bench: Bench) -> None:
    bench.ask(named("serial_output").set(True))
    bench.events += bench.link.abandon(bench.now)
    bench.answers.pop(BOOTS.encode())
    bench.ask(named("serial_output").set(False))
    bench.wait(3)
    assert bench.sent(named("serial_output").set(False)) == 0


def test_a_fence_that_this_module_does_not_know_is_replaced_by_the_boot_count_behind_it(bench: Bench) -> None:
    bench.is_there = False
    bench.ask(BOOTS)
    bench.events += bench.link.abandon(bench.now)  # one that may still be answered, so another question is the fence
    bench.is_there = True
    bench.answers.pop(named("charging").query().encode())
    output = named("serial_output").set(True)
    assert bench.begin_to_ask(output, is_fenced=True) == named("charging").query().encode()
    bench.wait(1.0)
    assert bench.sent(output) == 1
    assert bench.reasons == []


def test_abandoning_frees_the_link_and_the_reply_is_late(bench: Bench) -> None:
    bench.ask(named("light").query())
    bench.link.abandon(bench.now)
    assert bench.link.is_idle
    bench.hear(encode_reply(0x14, 3))
    assert bench.roles() == [Role.LATE]


@pytest.mark.promise("f")
def test_the_second_reply_to_a_repeated_question_acknowledges_no_set(bench: Bench) -> None:
    bench.ask(THRESHOLD.query())
    bench.wait(0.06)
    bench.hear(encode_reply(0x20, 60))
    assert bench.sent(THRESHOLD.query()) == 2
    assert bench.begin_to_ask(THRESHOLD.set(70)) in (b"", FENCE)
    bench.hear(encode_reply(0x20, 60), after_s=0.001)
    assert bench.roles() == [Role.ANSWER, Role.DUPLICATE]
    bench.wait(0.1)
    assert bench.sent(THRESHOLD.set(70)) == 1


@pytest.mark.promise("f")
def test_a_copy_of_a_reading_acknowledges_no_set(bench: Bench) -> None:
    bench.ask(THRESHOLD.query())
    bench.hear(encode_reply(0x20, 60))
    bench.begin_to_ask(THRESHOLD.set(70))
    bench.hear(encode_reply(0x20, 60), after_s=0.001)
    assert bench.roles() == [Role.ANSWER, Role.DUPLICATE]
    bench.wait(0.1)
    assert bench.sent(THRESHOLD.set(70)) == 1


@pytest.mark.promise("f")
def test_a_question_that_is_still_owed_an_answer_is_asked_behind_a_fence(bench: Bench) -> None:
    """Else each answer would be taken for the next one's, for ever, and look quicker than it is."""
    bench.ask(named("light").query())
    bench.wait(0.06)
    bench.hear(encode_reply(0x14, 3))
    assert bench.sent(named("light").query()) == 2
    assert bench.begin_to_ask(named("light").query()) in ANY_FENCE
    bench.hear(encode_reply(0x14, 4), after_s=0.001)
    assert bench.roles()[-1] is Role.LATE
    bench.wait(0.01)
    bench.hear(encode_reply(0x14, 5))
    assert last_answer(bench) == Reading(named("light"), 5)
    assert bench.taken(Answered)[-1].round_trip_s is not None


# Rules of their own

LIGHT, FREEFALL_TIME = named("light").query(), TIME.query()
