"""Where a conversation begins and ends. The numbers are those of the rules that were agreed on."""

import pytest

from protocol.catalogue import HEARTBEAT, LOCK, SERIAL_OUTPUT, TRIGGER_RECORDS
from protocol.events import Answered, Began, Ended, EndReason, OutcomeUnknown, Received, Role, Sent, Unanswered
from protocol.messages import encode_reply
from tests.support.line.link_bench import AGAIN, BOOTED, BOOTS, PULSE, RECORD, STREAMED, Bench, named

LIGHT = named("light").query()
SET = named("freefall_time").set(1.2)
ACKNOWLEDGED = encode_reply(0x22, 120)
ACTIVATE = named("activation").set(True)


@pytest.fixture
def bench() -> Bench:
    return Bench().begun()


def stream(bench: Bench, seconds: float, *, hz: float = 50.0) -> None:
    for _ in range(round(seconds * hz)):
        bench.hear(STREAMED, after_s=1 / hz)


# 1. When it is silent


@pytest.mark.promise("f")
@pytest.mark.parametrize("begins_s", [0.0, 0.05, 0.1, 0.15, 0.2])
def test_1_half_a_second_of_silence_is_always_noticed(bench: Bench, begins_s: float) -> None:
    bench.wait(begins_s)
    bench.is_there = False
    bench.wait(0.5)
    bench.is_there = True
    bench.wait(1.0)
    assert bench.reasons == [EndReason.SILENT]
    assert bench.begins == 1, "and another one begins"


@pytest.mark.parametrize(("reply_s", "silence_s"), [(0.001, 0.45), (0.03, 0.6), (0.1, 1.0), (0.4, 1.0)])
def test_1_a_silence_is_twenty_round_trips_but_half_a_second_to_a_second(reply_s: float, silence_s: float) -> None:
    bench = Bench(reply_s=reply_s).begun()
    bench.wait(5.0)
    assert bench.link.silence_s == pytest.approx(silence_s)
    bench.is_there = False
    bench.wait(3.0)
    (ended,) = bench.taken(Ended)
    last_heard = max(event.at for event in bench.taken(Received))
    assert ended.at - last_heard == pytest.approx(silence_s, abs=0.01)


# 2. The link asks when nobody asks


@pytest.mark.promise("f")
def test_2_another_module_that_streams_on_at_once_is_noticed_within_a_second(bench: Bench) -> None:
    stream(bench, 3.0)
    bench.answers[BOOTS.encode()] = encode_reply(0x23, 90)
    stream(bench, 1.1)
    assert bench.reasons == [EndReason.CONTRADICTED]


# 3. Repeats


def test_3_a_question_is_repeated_six_times_and_then_the_boot_count_is_asked(bench: Bench) -> None:
    bench.ask(LIGHT)
    asked_at = bench.now
    bench.wait(0.4)
    assert bench.sent(LIGHT) == 6
    (given_up,) = bench.taken(Unanswered)
    assert (given_up.request, given_up.attempts) == (LIGHT, 6)
    assert given_up.at - asked_at < 0.4
    assert bench.reasons == [], "it is there and does not answer this"


@pytest.mark.parametrize("reply_s", [0.003, 0.05, 0.1, 0.25])
@pytest.mark.parametrize("name", ["light", "trigger_records"])
def test_3_a_module_that_does_not_know_a_question_is_not_silent(reply_s: float, name: str) -> None:
    bench = Bench(reply_s=reply_s).begun()
    bench.wait(5.0)
    for _ in range(5):
        bench.ask(named(name).query())
        bench.wait(5.0)
    assert len(bench.taken(Unanswered)) == 5
    assert bench.reasons == []


@pytest.mark.promise("f")
def test_3_a_module_that_streams_and_hears_nothing_is_no_conversation(bench: Bench) -> None:
    """Its receive line is open: nothing that is sent reaches it."""
    bench.is_there = False
    stream(bench, 2.5)
    assert bench.reasons == [EndReason.SILENT]
    assert bench.begins == 0


# 4. A set waits for its own answer and for nothing else


def test_4_a_set_waits_up_to_a_second_for_its_own_answer(bench: Bench) -> None:
    bench.ask(SET)
    bench.is_there = False
    bench.hear(ACKNOWLEDGED, after_s=0.95)
    assert len(bench.taken(Answered)) == 1
    assert bench.reasons == []


@pytest.mark.promise("f")
def test_4_any_other_frame_after_a_silence_ends_the_conversation(bench: Bench) -> None:
    bench.ask(SET)
    bench.is_there = False
    bench.hear(STREAMED, after_s=0.5)
    assert bench.reasons == [EndReason.SILENT]
    assert bench.taken(Answered) == []


def test_4_the_boot_count_behind_it_tells_that_the_acknowledgement_is_lost(bench: Bench) -> None:
    bench.ask(SET)
    asked_at = bench.now
    bench.wait(0.3)
    (unknown,) = bench.taken(OutcomeUnknown)
    assert unknown.at - asked_at == pytest.approx(0.18, abs=0.01)
    assert bench.reasons == [], "the conversation goes on"
    bench.wait(2.0)
    assert bench.sent(SET) == 1


def test_4_without_any_answer_it_is_silent_after_a_second(bench: Bench) -> None:
    bench.ask(SET)
    bench.is_there = False
    asked_at = bench.now
    bench.wait(2.0)
    (ended,) = bench.taken(Ended)
    assert ended.reason is EndReason.SILENT
    assert ended.at - asked_at == pytest.approx(1.0, abs=0.01)


def test_4_the_boot_count_behind_records_tells_that_no_more_come(bench: Bench) -> None:
    bench.ask(TRIGGER_RECORDS.query())
    asked_at = bench.now
    bench.hear(RECORD)
    bench.wait(1.0)
    (answered,) = bench.taken(Answered)
    assert answered.at - asked_at == pytest.approx(0.5, abs=0.02)
    assert bench.reasons == []


# 5. A turn of our own


@pytest.mark.parametrize("asks", [True, False])
def test_5_a_turn_of_our_own_that_is_longer_than_a_silence_ends_it(bench: Bench, asks: bool) -> None:
    """What the port held is read first; when it came nobody knows."""
    if asks:
        bench.ask(LIGHT)
    bench.now += 0.6
    bench.events += bench.link.receive(STREAMED, bench.now)
    bench.events += bench.link.tick(bench.now)
    assert bench.reasons == [EndReason.SILENT]


def test_5_a_shorter_one_does_not(bench: Bench) -> None:
    bench.hear(*[STREAMED] * 5, after_s=0.1)
    bench.now += bench.link.silence_s - 0.05
    bench.events += bench.link.receive(STREAMED * 20, bench.now)
    bench.events += bench.link.tick(bench.now)
    assert bench.reasons == []


@pytest.mark.promise("i")
def test_5_nothing_that_was_decided_before_it_changes_a_module_after_it(bench: Bench) -> None:
    change = SERIAL_OUTPUT.set(True)
    bench.ask(LIGHT)
    bench.hear(encode_reply(0x14, 3))
    bench.now += 0.6
    bench.events += bench.link.ask(change, bench.now)
    bench.events += bench.link.tick(bench.now)
    bench._deliver()
    bench.wait(1.0)
    assert bench.sent(change) == 0
    assert bench.taken(Unanswered)
    assert bench.reasons == [EndReason.SILENT]


# 6. Restarts


@pytest.mark.promise("a")
def test_6_one_unasked_heartbeat_long_after_our_last_is_a_restart(bench: Bench) -> None:
    bench.wait(4.0)
    bench.hear(PULSE)
    assert bench.reasons == [EndReason.RESTARTED]
    assert bench.link.counters.restarts == 1


def test_6_the_second_heartbeat_belongs_to_the_first(bench: Bench) -> None:
    bench.wait(4.0)
    bench.hear(PULSE)
    bench.hear(PULSE, after_s=0.05)
    bench.wait(1.0)
    assert bench.reasons == [EndReason.RESTARTED]
    assert bench.begins == 1


@pytest.mark.promise("a")
def test_6_two_unasked_heartbeats_are_a_restart_even_soon_after_ours(bench: Bench) -> None:
    bench.ask(HEARTBEAT.query())
    bench.wait(0.5)
    bench.is_there = False  # it answers nothing yet
    bench.hear(PULSE)
    assert bench.reasons == []
    bench.hear(PULSE, after_s=0.05)
    assert bench.reasons == [EndReason.RESTARTED]


@pytest.mark.promise("a")
def test_6_any_other_unasked_heartbeat_makes_the_link_ask_the_boot_count_at_once(bench: Bench) -> None:
    bench.ask(HEARTBEAT.query())
    bench.wait(0.01)
    bench.answers[BOOTS.encode()] = encode_reply(0x23, BOOTED + 1)
    assert bench.hear(PULSE, after_s=0.05) == BOOTS.encode()
    bench.wait(0.01)
    assert bench.reasons == [EndReason.RESTARTED]


@pytest.mark.promise("i")
def test_6_what_waits_for_a_quiet_line_is_not_sent_after_one(bench: Bench) -> None:
    bench.ask(HEARTBEAT.query())
    bench.wait(0.01)
    bench.events += bench.link.ask(ACTIVATE, bench.now, is_deliberate=True)
    bench.hear(PULSE, after_s=0.03)
    bench.wait(2.0)
    assert bench.sent(ACTIVATE) == 0
    assert [event.attempts for event in bench.taken(Unanswered)] == [0]


@pytest.mark.promise("i")
def test_6_nothing_that_changes_the_module_leaves_before_its_boot_count_was_read_again(bench: Bench) -> None:
    """The heartbeat came together with the answer that the act waited for."""
    bench.ask(HEARTBEAT.query())
    bench.wait(0.1)
    bench.events += bench.link.receive(PULSE, bench.now)
    assert bench.link.ask(ACTIVATE, bench.now, is_deliberate=True) == [Unanswered(ACTIVATE, 0, 0.0, bench.now)]
    assert bench.ask(LOCK) == LOCK.encode()


# 7. Contradictions: see also test_stale_replies


@pytest.mark.promise("a")
@pytest.mark.parametrize("starts", [1, 2, 3])
def test_7_a_boot_count_that_grew_a_little_is_a_restart_of_which_nothing_was_heard(bench: Bench, starts: int) -> None:
    bench.answers[BOOTS.encode()] = encode_reply(0x23, BOOTED + starts)
    bench.wait(1.0)
    (ended,) = bench.taken(Ended)
    assert ended.reason is EndReason.RESTARTED
    assert bench.taken(Began)[-1].boot_count == BOOTED + starts


@pytest.mark.promise("f")
@pytest.mark.parametrize("boots", [BOOTED - 1, BOOTED + 4, 200])
def test_7_any_other_is_a_contradiction(bench: Bench, boots: int) -> None:
    bench.answers[BOOTS.encode()] = encode_reply(0x23, boots)
    bench.wait(1.0)
    (ended,) = bench.taken(Ended)
    assert ended.reason is EndReason.CONTRADICTED
    assert ended.contradiction is not None
    assert (ended.contradiction.before.raw, ended.contradiction.after.raw) == (BOOTED, boots)


# 8. How it begins


def test_8_it_begins_with_the_boot_count_and_not_with_any_answer() -> None:
    bench = Bench(is_there=False)
    stream(bench, 1.0)
    bench.hear(PULSE)
    assert bench.begins == 0
    bench.is_there = True
    bench.wait(1.2)
    assert bench.taken(Began)[0].boot_count == BOOTED


@pytest.mark.promise("f")
def test_8_a_late_answer_of_the_one_before_does_not_begin_it(bench: Bench) -> None:
    """The boot count was asked for while the line was dead; then it passes on what it held back."""
    bench.is_there = False
    bench.wait(2.0)
    bench.events.clear()
    bench.answers[BOOTS.encode()] = encode_reply(0x23, 90)
    bench.is_there = True
    bench.hear(AGAIN)
    bench.wait(3.0)
    assert [began.boot_count for began in bench.taken(Began)] == [90]


@pytest.mark.promise("j")
def test_8_lock_does_not_wait_for_it() -> None:
    bench = Bench(is_there=False)
    bench.wait(1.0)
    bench.events += bench.link.abandon(bench.now)
    assert bench.ask(LOCK, limit_s=0.06) == LOCK.encode()
    bench.wait(0.06)
    (unknown,) = bench.taken(OutcomeUnknown)
    assert unknown.request == LOCK


# 9. What outlives it


@pytest.mark.promise("f")
def test_9_a_late_answer_to_an_old_question_is_not_the_next_ones(bench: Bench) -> None:
    bench.is_there = False
    bench.ask(BOOTS)
    bench.events += bench.link.end(EndReason.ANOTHER, bench.now)
    bench.events += bench.link.tick(bench.now)
    assert bench.taken(Sent)[-1].request != BOOTS, "a fence"
    bench.hear(AGAIN)
    assert bench.taken(Received)[-1].role is Role.LATE
    assert bench.begins == 0


# 13. Directly before a frame


def test_13_the_link_asks_nothing_while_a_frame_waits_for_a_quiet_line(bench: Bench) -> None:
    bench.wait(0.17)
    before = bench.sent(BOOTS)
    bench.ask(named("active").query())
    while not bench.link.is_idle:
        bench.wait(0.001)
    assert bench.ask(ACTIVATE, is_deliberate=True) == ACTIVATE.encode()
    assert bench.sent(BOOTS) == before


# 16. Slow lines


@pytest.mark.parametrize(("reply_s", "allows"), [(0.003, True), (0.25, True), (0.35, False), (0.7, False)])
def test_16_on_a_slow_line_no_commands_are_allowed(reply_s: float, allows: bool) -> None:
    bench = Bench(reply_s=reply_s)
    bench.wait(3.0)
    for name in ("charging", "active", "triggered"):
        bench.ask(named(name).query())
        bench.wait(2.0)
    assert bench.reasons == []
    assert bench.link.allows_commands is allows
