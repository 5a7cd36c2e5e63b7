"""Late and doubled replies, and the fence: nothing that was asked before is taken for an answer."""

import pytest

from protocol.catalogue import HEARTBEAT, STATUS, TRIGGER_RECORDS
from protocol.events import Answered, Received, Role
from protocol.frame import encode_reply
from protocol.messages import Reading
from protocol.stale_replies import FENCES, StaleReplies
from protocol.timing import DOUBLED_S, LATE_S, RESTART_S
from tests.support.line.link_bench import BOOTS, PULSE, RECORD, STREAMED, TRAP, Bench, named

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


def test_an_answer_to_something_else_is_fence_enough(bench: Bench) -> None:
    bench.ask(TIME.set(1.8))
    bench.hear(encode_reply(0x22, 180))
    bench.ask(THRESHOLD.query())
    bench.hear(encode_reply(0x20, 60))
    assert bench.begin_to_ask(TIME.query()) == TIME.query().encode()


def test_long_after_its_acknowledgement_a_set_is_still_read_back_behind_a_fence() -> None:
    """A copy of it may come at any time, until a later request is answered."""
    stale = StaleReplies()
    stale.remember(TIME.set(1.8), 1.0)
    assert stale.could_answer(TIME.query(), 1000.0)
    stale.on_answered(named("light").query(), 1000.0, 1000.0)
    assert not stale.could_answer(TIME.query(), 1000.0)


def test_a_status_that_may_have_been_streamed_proves_nothing_about_what_was_asked_before(bench: Bench) -> None:
    activate = named("activation").set(True)
    bench.ask(activate, is_deliberate=True)
    bench.events += bench.link.abandon(bench.now)
    bench.ask(STATUS.query())
    bench.hear(STREAMED, after_s=0.001)
    assert bench.begin_to_ask(activate, is_deliberate=True) == FENCE


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


def test_what_was_half_heard_before_the_question_is_no_answer(bench: Bench) -> None:
    stale, fresh = encode_reply(0x14, 3), encode_reply(0x14, 18)
    bench.events += bench.link.receive(stale[:4], bench.now)
    bench.ask(named("light").query())
    bench.hear(stale[4:])
    assert bench.taken(Answered) == []
    bench.hear(fresh)
    assert last_answer(bench) == Reading(named("light"), 18)


def test_what_was_read_together_with_the_fences_answer_is_no_answer(bench: Bench) -> None:
    bench.ask(TIME.set(1.8))
    bench.hear(encode_reply(0x22, 180))
    bench.answers[BOOTS.encode()] += encode_reply(0x22, 180)
    bench.ask(TIME.query())
    assert len(bench.taken(Answered)) == 1
    bench.hear(encode_reply(0x22, 160))
    assert last_answer(bench) == Reading(TIME, 160)


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


def test_a_reading_may_come_a_third_time_but_a_third_status_was_streamed(bench: Bench) -> None:
    reading, status = encode_reply(0x20, 60), STREAMED
    for request, frame in ((THRESHOLD.query(), reading), (STATUS.query(), status)):
        bench.ask(request)
        bench.hear(frame)
        bench.hear(frame)
        bench.hear(frame)
    copied = [Role.ANSWER, Role.DUPLICATE, Role.DUPLICATE]
    assert bench.roles() == [*copied, Role.ANSWER, Role.DUPLICATE, Role.STREAMED]


@pytest.mark.promise("f")
def test_a_copy_of_a_reading_acknowledges_no_set(bench: Bench) -> None:
    bench.ask(THRESHOLD.query())
    bench.hear(encode_reply(0x20, 60))
    bench.begin_to_ask(THRESHOLD.set(70))
    bench.hear(encode_reply(0x20, 60), after_s=0.001)
    assert bench.roles() == [Role.ANSWER, Role.DUPLICATE]
    bench.wait(0.1)
    assert bench.sent(THRESHOLD.set(70)) == 1


def test_a_copy_that_answers_a_question_leaves_its_own_answer_to_come(bench: Bench) -> None:
    for _ in range(2):
        bench.ask(THRESHOLD.query())
        bench.hear(encode_reply(0x20, 60), after_s=0.001)
    bench.wait(0.1)
    assert bench.begin_to_ask(THRESHOLD.set(70)) in ANY_FENCE


def test_the_same_question_over_and_over_is_timed_each_time(bench: Bench) -> None:
    """All answers are the same, and come as quickly as copies."""
    for _ in range(20):
        bench.ask(HEARTBEAT.query())
        bench.wait(0.0031)
    assert [answered.round_trip_s for answered in bench.taken(Answered)] == [pytest.approx(0.003)] * 20


def test_a_status_that_a_copy_stood_for_is_late_and_not_streamed(bench: Bench) -> None:
    """It says what was so when it was asked for, however long ago."""
    for _ in range(2):
        bench.ask(STATUS.query())
        bench.hear(STREAMED, after_s=0.001)
    assert bench.roles() == [Role.ANSWER, Role.ANSWER]
    bench.hear(STREAMED, STREAMED, after_s=0.1)
    assert bench.roles()[2:] == [Role.LATE, Role.LATE]
    bench.hear(STREAMED, after_s=0.1)
    assert bench.roles()[4:] == [Role.STREAMED]


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


def test_an_answer_does_not_pass_by_what_was_asked_after_it(bench: Bench) -> None:
    """The boot count behind a set is answered after the set."""
    bench.is_there = False
    bench.ask(TIME.set(1.8))
    bench.wait(0.2)
    behind = bench.sent(BOOTS)
    bench.hear(encode_reply(0x22, 180), after_s=0.001)
    for _ in range(behind):
        bench.hear(bench.answers[BOOTS.encode()], after_s=0.001)
    assert Role.UNSOLICITED not in [event.role for event in bench.taken(Received)]
    assert not bench.link.told.is_answered_twice(bench.now)


# Rules of their own

LIGHT, FREEFALL_TIME = named("light").query(), TIME.query()


@pytest.mark.parametrize(("passed_s", "is_late"), [(LATE_S, True), (LATE_S + 0.1, False)])
def test_a_late_reply_counts_until_its_time_is_over(passed_s: float, is_late: bool) -> None:
    stale = StaleReplies()
    stale.expect_late(FREEFALL_TIME, 1.0, count=1)
    assert stale.could_be_late(FREEFALL_TIME, 1.0 + passed_s) is is_late or passed_s > LATE_S
    stale.drop_expired(1.0 + passed_s)
    late = stale.pop_late(encode_reply(0x22, 160))
    assert (late is not None) is is_late
    assert stale.pop_late(encode_reply(0x22, 160)) is None, "one was owed"


@pytest.mark.parametrize(("passed_s", "is_copy"), [(DOUBLED_S, True), (DOUBLED_S + 0.001, False)])
def test_a_copy_counts_until_its_time_is_over(passed_s: float, is_copy: bool) -> None:
    stale, reply = StaleReplies(), encode_reply(0x22, 160)
    stale.expect_copy(reply, FREEFALL_TIME, 0.0)
    copied = stale.copied(reply, passed_s)
    assert (copied is not None) is is_copy
    assert stale.copied(encode_reply(0x22, 161), 0.0) is None
    assert copied is None or not copied.is_late
    assert stale.could_answer(TIME.set(1.6), passed_s) is is_copy
    assert not stale.could_answer(FREEFALL_TIME, 0.0), "the same question: as good"
    stale.expect_no_copy(reply)
    assert stale.copied(reply, 0.0) is None


@pytest.mark.promise("f")
def test_no_fence_is_a_heartbeat() -> None:
    stale = StaleReplies()
    assert stale.fence(0.0) == FENCES[0] == BOOTS
    for fence in FENCES:
        stale.expect_late(fence, 0.0, count=1)
        assert stale.fence(0.0) != HEARTBEAT.query()


@pytest.mark.promise("f")
@pytest.mark.parametrize("owed", [fence.command.name for fence in FENCES[:-1]])
def test_a_fence_is_a_question_to_which_nothing_is_owed(owed: str) -> None:
    stale = StaleReplies()
    stale.expect_late(named(owed).query(), 0.0, count=1)
    fence = stale.fence(0.0)
    assert fence != named(owed).query()
    assert stale.opens(fence, encode_reply(fence.command.code, 0), 0.0)
    assert not stale.opens(named(owed).query(), encode_reply(named(owed).code, 0), 0.0)


@pytest.mark.parametrize(("apart_s", "is_in_doubt"), [(RESTART_S - 0.01, True), (RESTART_S + 0.1, False)])
def test_a_heartbeat_soon_after_another_proves_nothing(apart_s: float, is_in_doubt: bool) -> None:
    """It may be the second one of a restart."""
    stale = StaleReplies()
    stale.expect_late(FREEFALL_TIME, 0.5, count=1)
    stale.on_heartbeat(1.0)
    stale.on_heartbeat(1.0 + apart_s)
    stale.on_answered(HEARTBEAT.query(), 0.9, 1.0 + apart_s)
    assert (stale.pop_late(encode_reply(0x22, 160)) is not None) is is_in_doubt


def test_after_an_answer_only_its_own_copy_may_follow() -> None:
    stale, earlier, last = StaleReplies(), encode_reply(0x22, 160), encode_reply(0x14, 1)
    stale.expect_copy(earlier, FREEFALL_TIME, 0.0)
    stale.expect_copy(last, LIGHT, 0.0)
    stale.on_answered(LIGHT, 0.0, 0.0)
    copied = stale.copied(last, 0.0)
    assert copied is not None
    assert copied.request == LIGHT
    assert stale.copied(earlier, 0.0) is None


def test_a_copy_of_a_heartbeat_is_no_restart(bench: Bench) -> None:
    bench.ask(HEARTBEAT.query())
    bench.wait(0.003)
    bench.hear(PULSE, after_s=0.0)
    bench.wait(1.0)
    assert bench.reasons == []
