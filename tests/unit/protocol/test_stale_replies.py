"""What must not be taken for an answer, and the pauses before a request.

E4: when 16 and 17 may be set, and when what was acknowledged counts.
"""

import pytest

from protocol.catalogue import TRIGGER_RECORDS, Request
from protocol.events import Answered, Ended, EndReason, Received, Role, Unanswered
from protocol.messages import Reading, encode_reply
from protocol.stale_replies import FENCES
from protocol.timing import LOST_IN_A_ROW, QUESTION_S, Gap
from tests.unit.protocol.link_bench import BOOTS, RECORD, STREAMED, TRAP, Bench, named

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
@pytest.mark.parametrize("is_doubled", [True, False])
def test_a_read_back_is_never_the_late_or_doubled_acknowledgement(bench: Bench, is_doubled: bool) -> None:
    """A module that echoes late and does not keep: its echo must not pass for the value read back."""
    bench.ask(TIME.set(1.8))
    if is_doubled:
        bench.hear(encode_reply(0x22, 180))
    else:
        bench.wait(0.3)
    assert bench.begin_to_ask(TIME.query()) in ANY_FENCE
    bench.hear(encode_reply(0x22, 180), after_s=0.001)
    bench.wait(0.01)
    bench.hear(encode_reply(0x22, 160))
    assert last_answer(bench) == Reading(TIME, 160)


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


@pytest.mark.promise("f")
def test_the_copy_of_a_late_report_is_as_old_as_that(bench: Bench) -> None:
    bench.ask(named("status").query())
    bench.events += bench.link.abandon(bench.now)
    bench.hear(STREAMED, STREAMED)
    assert bench.roles() == [Role.LATE, Role.LATE]


# Rules of their own

NAMES = ("light_threshold", "attitude_threshold", "freefall_acceleration", "freefall_time")
LATER_S = [0.0, 0.002, 0.5, 10.0]


def told(bench: Bench) -> list[tuple[str, int, int]]:
    """The setting and both values of each contradiction."""
    pairs = [ended.contradiction for ended in bench.taken(Ended) if ended.contradiction is not None]
    return [(before.command.name, before.raw, after.raw) for before, after in pairs]


@pytest.mark.parametrize("after_s", LATER_S)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.promise("f")
def test_a_second_answer_that_differs_contradicts_the_first(bench: Bench, name: str, after_s: float) -> None:
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


@pytest.mark.parametrize("name", NAMES)
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
    bench.ask(TIME.query())
    bench.hear(encode_reply(0x22, 160))
    bench.ask(TIME.set(1.2))
    bench.hear(encode_reply(0x22, 1), after_s=0.05)  # E2
    bench.hear(encode_reply(0x22, 1), after_s=1.0)
    bench.ask(TIME.query())
    bench.hear(encode_reply(0x22, 120), after_s=0.02)
    assert last_answer(bench) == Reading(TIME, 120)
    bench.hear(encode_reply(0x22, 1), after_s=0.5)
    assert bench.reasons == []
    bench.wait(6.0)
    bench.ask(TIME.query())
    bench.hear(encode_reply(0x22, 160))
    assert told(bench) == [("freefall_time", 120, 160)], "it changed by itself, or it is another module"


def ask(gap: Gap, *, attempts: int) -> None:
    for _ in range(attempts):
        gap.on_spoken(0.0)
    gap.on_answered(attempts)


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
    assert gap.due(TIME.query(), 1.0) == 1.0 + QUESTION_S, "it stays"


ATTITUDE, FREEFALL = named("attitude_trigger").set(True), named("freefall_trigger").set(True)
LATE_S = 3.0


@pytest.fixture
def waited() -> Bench:
    waited = Bench().begun()
    waited.wait(LATE_S)
    waited.events.clear()
    return waited


def is_sent(waited: Bench, request: Request) -> bool:
    """Whether the link sends it now; else it says that it never left."""
    before = waited.sent(request)
    waited.ask(request)
    waited.wait(0.02)  # behind a fence
    is_out = waited.sent(request) > before
    if not is_out:
        assert waited.taken(Unanswered)[-1]._replace(at=0) == Unanswered(request, 0, 0.0, 0)
    return is_out


def are_known(waited: Bench) -> bool:
    return waited.link.flags.are_known(waited.now)


def test_16_follows_directly_where_17_was_answered_under_17(waited: Bench) -> None:
    assert is_sent(waited, FREEFALL)
    waited.hear(encode_reply(0x17, 0))
    assert not is_sent(waited, named("freefall_trigger").set(False)), "a copy may come"
    assert is_sent(waited, ATTITUDE)
    waited.hear(encode_reply(0x16, 0))
    assert len(waited.taken(Answered)) == 2


@pytest.mark.promise("f")
def test_the_wait_outlives_the_conversation(waited: Bench) -> None:
    assert is_sent(waited, FREEFALL)
    waited.hear(encode_reply(0x16, 0))
    waited.events += waited.link.end(EndReason.ANOTHER, waited.now)
    waited.wait(1.0)
    assert waited.begins == 1
    assert not is_sent(waited, ATTITUDE)


@pytest.mark.parametrize("after_s", [0.001, 0.05, 0.5, 2.9, 4.0])
def test_where_an_acknowledgement_comes_twice_nothing_counts_in_this_conversation(
    waited: Bench, after_s: float
) -> None:
    assert is_sent(waited, FREEFALL)
    waited.hear(encode_reply(0x17, 0))
    waited.hear(encode_reply(0x17, 0), after_s=after_s)
    waited.wait(60.0)
    assert not are_known(waited)
    assert is_sent(waited, ATTITUDE)
    waited.hear(encode_reply(0x16, 0))
    waited.wait(60.0)
    assert not are_known(waited)
    waited.events += waited.link.end(EndReason.ANOTHER, waited.now)
    waited.wait(LATE_S)
    assert are_known(waited)


def test_an_acknowledgement_that_comes_late_is_no_second_one(waited: Bench) -> None:
    assert is_sent(waited, FREEFALL)
    waited.wait(1.5)
    assert waited.taken(Unanswered)[-1].may_be_done
    waited.hear(encode_reply(0x17, 0))
    assert not are_known(waited)
    waited.wait(LATE_S)
    assert are_known(waited)
    waited.hear(encode_reply(0x17, 0))
    waited.wait(LATE_S)
    assert not are_known(waited), "and this is one"
