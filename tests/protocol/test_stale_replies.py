"""Late and doubled replies, restarts, and the fence: nothing that was asked before is taken for an answer."""

import pytest

from protocol.catalogue import HEARTBEAT, STATUS, TRIGGER_RECORDS
from protocol.events import Answered, Restarted, Role, Sent, Unanswered
from protocol.frame import encode_reply
from protocol.messages import Reading
from protocol.round_trips import Timing
from protocol.stale_replies import StaleReplies
from tests.support.line.link_bench import PULSE, RECORD, STREAMED, TRAP, Bench, named


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_e03_a_voltage_asked_after_records_waits_behind_a_fence(bench: Bench) -> None:
    bench.ask(TRIGGER_RECORDS.query())
    bench.hear(RECORD)
    bench.wait(0.6)
    assert bench.ask(named("cell_voltage").query()) == HEARTBEAT.query().encode()
    bench.hear(TRAP, after_s=0.01)  # a record that took its time
    assert not [e for e in bench.taken(Answered) if e.request.command.name == "cell_voltage"]
    assert bench.hear(PULSE) == named("cell_voltage").query().encode()
    bench.hear(encode_reply(0x35, 0xC8))
    (voltage,) = [e for e in bench.taken(Answered) if e.request.command.name == "cell_voltage"]
    (message,) = voltage.messages
    assert isinstance(message, Reading)
    assert message.value == 4.0


def test_a_read_back_is_never_the_late_acknowledgement(bench: Bench) -> None:
    """A module that echoes late and does not keep: its echo must not pass for the value read back."""
    bench.warm_up()
    bench.ask(named("freefall_time").set(1.8))
    bench.wait(1.01)
    sent = bench.ask(named("freefall_time").query())
    assert sent == HEARTBEAT.query().encode()
    bench.hear(encode_reply(0x22, 180), after_s=0.05)
    sent = bench.hear(PULSE)
    assert sent == named("freefall_time").query().encode()
    bench.hear(encode_reply(0x22, 160))
    (answered,) = bench.taken(Answered)
    assert answered.messages == (Reading(named("freefall_time"), 160),)


def test_a_doubled_acknowledgement_is_not_the_read_back(bench: Bench) -> None:
    bench.warm_up()
    bench.ask(named("freefall_time").set(1.8))
    bench.hear(encode_reply(0x22, 180))
    assert bench.ask(named("freefall_time").query()) == HEARTBEAT.query().encode()
    bench.hear(encode_reply(0x22, 180), after_s=0.001)
    assert bench.hear(PULSE) == named("freefall_time").query().encode()
    bench.hear(encode_reply(0x22, 160))
    answers = bench.taken(Answered)
    assert answers[-1].messages == (Reading(named("freefall_time"), 160),)


def test_an_answer_to_something_else_is_fence_enough(bench: Bench) -> None:
    bench.warm_up()
    bench.ask(named("freefall_time").set(1.8))
    bench.hear(encode_reply(0x22, 180))
    bench.ask(named("attitude_threshold").query())
    bench.hear(encode_reply(0x20, 60))
    assert bench.ask(named("freefall_time").query()) == named("freefall_time").query().encode()


def test_a_status_that_may_have_been_streamed_proves_nothing_about_what_was_asked_before(bench: Bench) -> None:
    bench.ask(named("activation").set(True), waits_s=(0.1,), is_deliberate=True)
    bench.wait(0.11)
    bench.ask(named("status").query())
    bench.hear(STREAMED)
    assert bench.ask(named("activation").set(True), is_deliberate=True) == HEARTBEAT.query().encode()


def test_a_fence_without_answer_sends_nothing_else(bench: Bench) -> None:
    bench.warm_up()
    bench.ask(named("serial_output").set(True))
    bench.wait(1.01)
    bench.events.clear()
    bench.ask(named("serial_output").set(False))
    bench.wait(3)
    assert not [e for e in bench.taken(Sent) if e.request.is_set]
    (given_up,) = bench.taken(Unanswered)
    assert given_up.attempts == 0


def test_two_unasked_heartbeats_are_a_restart(bench: Bench) -> None:
    bench.warm_up()
    bench.hear(PULSE, after_s=1)
    assert bench.taken(Restarted) == []
    bench.hear(PULSE, after_s=0.05)
    assert [event.is_certain for event in bench.taken(Restarted)] == [True]
    assert bench.link.counters.restarts == 1


@pytest.mark.parametrize("count", [1, 2])
def test_unasked_heartbeats_one_or_both_read_at_once_are_a_restart(bench: Bench, count: int) -> None:
    bench.warm_up()
    bench.hear(*[PULSE] * count, after_s=1)
    bench.wait(0.31)
    assert [event.is_certain for event in bench.taken(Restarted)] == [False]


def test_a_doubled_heartbeat_is_no_restart(bench: Bench) -> None:
    bench.ask(HEARTBEAT.query())
    bench.hear(PULSE, PULSE)
    bench.wait(1)
    assert bench.taken(Restarted) == []
    assert bench.roles() == [Role.ANSWER, Role.DUPLICATE]


def test_a_restart_during_a_heartbeat_is_seen(bench: Bench) -> None:
    bench.ask(HEARTBEAT.query())
    bench.hear(PULSE)
    bench.hear(PULSE, after_s=0.05)
    bench.wait(0.5)
    assert len(bench.taken(Restarted)) == 1


def test_a_late_heartbeat_is_no_restart(bench: Bench) -> None:
    bench.ask(HEARTBEAT.query(), waits_s=(0.5, 1.0))
    bench.wait(0.6)
    bench.hear(PULSE, after_s=0.1)
    bench.hear(PULSE, after_s=0.1)
    bench.wait(1)
    assert bench.taken(Restarted) == []


def test_abandoning_frees_the_link_and_the_reply_is_late(bench: Bench) -> None:
    bench.ask(named("light").query())
    bench.link.abandon(bench.now)
    assert bench.link.is_idle
    bench.hear(encode_reply(0x14, 3))
    assert bench.roles() == [Role.LATE]


def test_what_was_half_heard_before_the_question_is_no_answer(bench: Bench) -> None:
    stale, fresh = encode_reply(0x14, 3), encode_reply(0x14, 18)
    bench.hear(stale[:4])
    bench.ask(named("light").query())
    bench.hear(stale[4:])
    assert bench.taken(Answered) == []
    bench.hear(fresh)
    (answered,) = bench.taken(Answered)
    assert answered.messages == (Reading(named("light"), 18),)


def test_what_was_read_together_with_the_fences_answer_is_no_answer(bench: Bench) -> None:
    bench.ask(named("freefall_time").set(1.8))
    bench.hear(encode_reply(0x22, 180))
    bench.ask(named("freefall_time").query())
    assert bench.hear(PULSE + encode_reply(0x22, 180)) == named("freefall_time").query().encode()
    assert len(bench.taken(Answered)) == 1
    bench.hear(encode_reply(0x22, 160))
    answered = bench.taken(Answered)[-1]
    assert answered.messages == (Reading(named("freefall_time"), 160),)


def test_the_second_reply_to_a_repeated_question_acknowledges_no_set(bench: Bench) -> None:
    bench.ask(named("attitude_threshold").query(), waits_s=(0.1, 0.1))
    bench.wait(0.15)
    bench.hear(encode_reply(0x20, 60))
    assert len(bench.taken(Answered)) == 1
    bench.wait(0.05)
    assert bench.ask(named("attitude_threshold").set(70)) == HEARTBEAT.query().encode()
    bench.hear(encode_reply(0x20, 60))
    assert bench.roles() == [Role.ANSWER, Role.LATE]
    assert bench.hear(PULSE) == named("attitude_threshold").set(70).encode()


def test_a_reading_may_come_a_third_time_but_a_third_status_was_streamed(bench: Bench) -> None:
    reading, status = encode_reply(0x20, 60), STREAMED
    for request, frame in ((named("attitude_threshold").query(), reading), (STATUS.query(), status)):
        bench.ask(request)
        bench.hear(frame)
        bench.hear(frame)
        bench.hear(frame)
    copied = [Role.ANSWER, Role.DUPLICATE, Role.DUPLICATE]
    assert bench.roles() == [*copied, Role.ANSWER, Role.DUPLICATE, Role.STREAMED]


@pytest.mark.parametrize(("waited_s", "role"), [(2.0, Role.LATE), (60.0, Role.UNSOLICITED)])
def test_a_reply_is_late_only_until_its_time_is_over(waited_s: float, role: Role, bench: Bench) -> None:
    bench.ask(named("light").query(), attempts=1)
    bench.wait(waited_s)
    bench.hear(encode_reply(named("light").code, 1))
    assert bench.roles() == [role]


def test_a_second_copy_of_a_reading_acknowledges_no_set(bench: Bench) -> None:
    bench.ask(named("attitude_threshold").query())
    bench.hear(encode_reply(0x20, 60))
    assert bench.ask(named("attitude_threshold").set(70)) == HEARTBEAT.query().encode()
    bench.hear(encode_reply(0x20, 60))
    assert bench.roles() == [Role.ANSWER, Role.DUPLICATE]


def test_a_copy_that_answers_the_same_question_again_passes_nothing_by(bench: Bench) -> None:
    bench.ask(HEARTBEAT.query())
    bench.hear(PULSE)
    bench.ask(named("freefall_time").set(1.8))
    bench.link.abandon(bench.now)
    bench.ask(HEARTBEAT.query())
    bench.hear(PULSE)
    assert len(bench.taken(Answered)) == 2
    assert bench.ask(named("freefall_time").set(1.2)) == named("boot_count").query().encode()


def test_a_copy_that_answers_a_question_leaves_its_own_answer_to_come(bench: Bench) -> None:
    threshold = named("attitude_threshold")
    for _ in range(2):
        bench.ask(threshold.query())
        bench.hear(encode_reply(0x20, 60), after_s=0.001)
    bench.wait(0.1)
    assert bench.ask(threshold.set(70)) == HEARTBEAT.query().encode()


def test_a_status_that_a_copy_stood_for_is_late_and_not_streamed() -> None:
    """It says what was so when it was asked for, however long ago; found by the stateful test of the engine."""
    bench = Bench()
    for _ in range(2):
        bench.ask(named("status").query())
        bench.hear(STREAMED, after_s=0.001)
    assert bench.roles() == [Role.ANSWER, Role.ANSWER]
    bench.hear(STREAMED, STREAMED, after_s=0.3)
    assert bench.roles()[2:] == [Role.LATE, Role.LATE]
    bench.hear(STREAMED, after_s=0.1)
    assert bench.roles()[4:] == [Role.STREAMED]


def test_each_attempt_may_still_be_answered(bench: Bench) -> None:
    bench.ask(HEARTBEAT.query(), waits_s=(0.1, 0.1, 0.1))
    bench.wait(0.4)
    for _ in range(3):
        bench.hear(PULSE, after_s=0.05)
    bench.wait(0.4)
    assert bench.roles() == [Role.LATE] * 3
    assert bench.taken(Restarted) == []


def test_the_late_answer_to_an_earlier_question_passes_nothing_by(bench: Bench) -> None:
    bench.ask(named("light").query(), waits_s=(0.1,))
    bench.wait(0.11)
    bench.ask(named("attitude_threshold").set(70), waits_s=(0.1,))
    bench.wait(0.11)
    bench.ask(named("light").query(), waits_s=(0.1,))
    bench.hear(encode_reply(0x14, 3))  # it may be the first question's: it says nothing of what was asked since
    assert bench.ask(named("attitude_threshold").query()) == HEARTBEAT.query().encode()


def test_a_copy_of_a_heartbeat_opens_no_fence(bench: Bench) -> None:
    bench.ask(HEARTBEAT.query())
    bench.hear(PULSE)
    bench.ask(named("freefall_time").query(), waits_s=(0.1,))
    bench.link.abandon(bench.now)
    assert bench.ask(named("freefall_time").set(1.8)) == named("boot_count").query().encode()
    assert bench.hear(PULSE, after_s=0.01) == b""
    assert bench.roles() == [Role.ANSWER, Role.DUPLICATE]
    bench.hear(encode_reply(0x22, 180), after_s=0.02)
    assert bench.hear(encode_reply(0x23, 37)) == named("freefall_time").set(1.8).encode()


def test_the_second_heartbeat_of_a_restart_opens_no_fence(bench: Bench) -> None:
    bench.ask(named("activation").set(True), waits_s=(0.1,), is_deliberate=True)
    bench.wait(0.11)
    assert bench.ask(named("activation").set(True), is_deliberate=True) == HEARTBEAT.query().encode()
    bench.hear(PULSE)  # the module restarts: the first of two
    bench.link.abandon(bench.now)
    assert bench.ask(named("activation").set(True), is_deliberate=True) == named("boot_count").query().encode()
    assert bench.hear(PULSE, after_s=0.05) == b""


def test_the_second_heartbeat_of_a_restart_passes_nothing_by(bench: Bench) -> None:
    bench.ask(HEARTBEAT.query())
    bench.hear(PULSE)  # the module restarts: the first of two
    bench.ask(named("serial_output").set(True))
    bench.link.abandon(bench.now)
    bench.ask(HEARTBEAT.query())
    bench.hear(PULSE, after_s=0.05)
    assert bench.ask(named("serial_output").set(False)) == named("boot_count").query().encode()


def test_while_a_heartbeat_is_owed_the_fence_is_another_question(bench: Bench) -> None:
    bench.ask(HEARTBEAT.query(), waits_s=(0.1,))
    bench.wait(0.1)
    bench.ask(named("serial_output").set(True), waits_s=(0.1,))
    bench.wait(0.11)
    fence = bench.ask(named("serial_output").set(False))
    assert fence == named("boot_count").query().encode()
    assert bench.hear(PULSE) == b""  # late
    assert bench.hear(encode_reply(0x23, 37)) == named("serial_output").set(False).encode()


def test_a_fence_of_which_the_answer_cannot_be_told_waits_for_the_heartbeat(bench: Bench) -> None:
    for name in ("heartbeat", "boot_count", "charging", "active", "triggered"):
        bench.ask(named(name).query(), waits_s=(0.1,))
        bench.wait(0.1)
    bench.ask(named("serial_output").set(True), waits_s=(0.1,))
    bench.wait(0.11)
    assert bench.ask(named("serial_output").set(False)) == HEARTBEAT.query().encode()
    assert bench.hear(PULSE, after_s=0.05) == b""
    assert bench.hear(PULSE, after_s=0.05) == named("serial_output").set(False).encode()


def test_one_heartbeat_alone_does_not_prove_that_nothing_more_will_come(bench: Bench) -> None:
    bench.warm_up()
    bench.ask(named("freefall_time").set(1.8), waits_s=(0.1,))
    bench.wait(0.11)
    bench.hear(PULSE)
    bench.wait(0.31)
    assert len(bench.taken(Restarted)) == 1
    assert bench.ask(named("freefall_time").query()) != named("freefall_time").query().encode()


def test_a_restart_is_seen_although_heartbeats_were_never_answered(bench: Bench) -> None:
    """They were asked of a module that was off; what it answered since proves that no reply to them is to come."""
    bench.ask(HEARTBEAT.query())
    bench.wait(3.5)  # all attempts
    bench.ask(named("boot_count").query())
    bench.hear(encode_reply(0x23, 37))
    bench.hear(PULSE, after_s=0.5)
    bench.hear(PULSE, after_s=0.05)
    assert bench.taken(Restarted)


SOON = Timing(late_s=4.0, doubled_s=0.5, restart_s=0.25)
LIGHT, FREEFALL_TIME = named("light").query(), named("freefall_time").query()


@pytest.mark.parametrize(("passed_s", "is_late"), [(4.0, True), (4.125, False)])
def test_a_late_reply_counts_until_its_time_is_over(passed_s: float, is_late: bool) -> None:
    stale = StaleReplies(SOON)
    stale.expect_late(FREEFALL_TIME, 1.0, count=1)
    stale.drop_expired(1.0 + passed_s)
    assert stale.pop_late(encode_reply(0x22, 160)) == (FREEFALL_TIME if is_late else None)
    assert stale.pop_late(encode_reply(0x22, 160)) is None, "one was owed"


@pytest.mark.parametrize(("passed_s", "is_copy"), [(0.5, True), (0.625, False)])
def test_a_copy_counts_until_its_time_is_over(passed_s: float, is_copy: bool) -> None:
    stale, reply = StaleReplies(SOON), encode_reply(0x22, 160)
    stale.expect_copy(reply, FREEFALL_TIME, 1.0)
    copied = stale.copied(reply, 1.0 + passed_s)
    assert (copied is not None) is is_copy
    assert stale.copied(encode_reply(0x22, 161), 1.0) is None
    assert copied is None or not copied.is_late
    assert stale.could_answer(named("freefall_time").set(1.6), 1.0 + passed_s) is is_copy
    assert not stale.could_answer(FREEFALL_TIME, 1.0), "the same question: as good"
    stale.expect_no_copy(reply)
    assert stale.copied(reply, 1.0) is None


@pytest.mark.parametrize(("passed_s", "is_in_doubt"), [(0.25, True), (0.375, False)])
def test_soon_after_a_heartbeat_the_fence_is_another_question(passed_s: float, is_in_doubt: bool) -> None:
    stale = StaleReplies(SOON)
    stale.on_heartbeat(1.0)
    assert (stale.fence(1.0 + passed_s) == HEARTBEAT.query()) is not is_in_doubt
    assert stale.fence(1.0 + passed_s, is_proof=True) != HEARTBEAT.query()


@pytest.mark.parametrize(("apart_s", "is_in_doubt"), [(0.25, True), (0.375, False)])
def test_a_heartbeat_soon_after_another_proves_nothing(apart_s: float, is_in_doubt: bool) -> None:
    stale = StaleReplies(SOON)
    stale.expect_late(FREEFALL_TIME, 0.5, count=1)
    stale.on_heartbeat(1.0)
    stale.on_heartbeat(1.0 + apart_s)
    stale.on_answered(HEARTBEAT.query(), 0.0)
    assert (stale.pop_late(encode_reply(0x22, 160)) is not None) is is_in_doubt


def test_after_an_answer_only_its_own_copy_may_follow() -> None:
    stale, earlier, last = StaleReplies(SOON), encode_reply(0x22, 160), encode_reply(0x14, 1)
    stale.expect_copy(earlier, FREEFALL_TIME, 1.0)
    stale.expect_copy(last, LIGHT, 1.0)
    stale.on_answered(LIGHT, 0.0)
    copied = stale.copied(last, 1.0)
    assert copied is not None
    assert copied.request == LIGHT
    assert stale.copied(earlier, 1.0) is None
