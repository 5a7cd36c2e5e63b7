"""Where a conversation begins and ends, by the numbers of the agreed rules; what is sent, believed and counted."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.catalogue import COMMANDS, HEARTBEAT, LOCK, SERIAL_OUTPUT, TRIGGER_RECORDS, Hazard, Layout, Request
from protocol.events import Answered, Began, Ended, EndReason, Received, Role, Sent, Unanswered
from protocol.link import LinkMisused
from protocol.messages import Heartbeat, Message, TriggerRecord, answers, decode, encode_reply
from protocol.stale_replies import FENCES
from protocol.timing import TRIES
from tests.support.thorough import IS_THOROUGH
from tests.unit.protocol.link_bench import AGAIN, BOOTED, BOOTS, PULSE, RECORD, STREAMED, TRAP, Bench, named
from tests.unit.protocol.nasty_bytes import hostile_bytes
from tests.unit.protocol.reference_decoder import sum_is_right
from tests.vendor.frames import FROM_MODULE

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
    assert bench.link.round_trips.silence_s == pytest.approx(silence_s)
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
    assert (given_up.request, given_up.attempts, given_up.may_be_done) == (LIGHT, 6, False)
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
    (unknown,) = bench.unknown()
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
@pytest.mark.parametrize(("longer_s", "reasons"), [(0.1, [EndReason.SILENT]), (-0.05, [])])
def test_5_a_turn_of_our_own_that_is_longer_than_a_silence_ends_it(
    bench: Bench, asks: bool, longer_s: float, reasons: list[EndReason]
) -> None:
    """What the port held is read first; when it came nobody knows."""
    bench.hear(STREAMED, after_s=0.1)
    if asks:
        bench.ask(LIGHT)
    bench.now += bench.link.round_trips.silence_s + longer_s
    bench.events += bench.link.receive(STREAMED * 20, bench.now)
    bench.events += bench.link.tick(bench.now)
    assert bench.reasons == reasons


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
    bench.hear(PULSE, after_s=0.05)
    bench.wait(1.0)
    assert bench.reasons == [EndReason.RESTARTED], "the second heartbeat belongs to the first"
    assert (bench.begins, bench.link.counters.restarts) == (1, 1)


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
    (unknown,) = bench.unknown()
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


def test_what_waited_behind_a_fence_that_nobody_answered_was_never_sent(bench: Bench) -> None:
    bench.is_there = False
    bench.begin_to_ask(SET, is_fenced=True)
    bench.wait(2.0)
    (never_sent,) = bench.taken(Unanswered)
    assert (never_sent.request, never_sent.attempts, never_sent.may_be_done) == (SET, 0, False)


def test_what_may_be_the_beginning_of_more_is_decided_when_the_line_is_quiet(bench: Bench) -> None:
    bench.is_there = False
    bench.hear(encode_reply(0x35, 0xC8))  # a voltage, or the beginning of a record
    assert bench.roles() == []
    bench.wait(0.3)
    assert bench.roles() == [Role.UNSOLICITED]


@pytest.mark.promise("i")
@pytest.mark.parametrize("name", ["deploy", "activation", "shutdown"])
def test_a_dangerous_request_needs_an_explicit_act_and_goes_out_once(bench: Bench, name: str) -> None:
    request = named(name).set(True)
    assert request.hazard is Hazard.DANGEROUS
    with pytest.raises(LinkMisused):
        bench.link.ask(request, bench.now)
    bench.wait(1.0)
    assert not bench.sent(request)
    bench.ask(request, is_deliberate=True)
    bench.wait(60)
    assert bench.sent(request) == 1
    assert len(bench.unknown()) == 1


def test_e06_all_records_until_the_line_is_quiet_in_order(bench: Bench) -> None:
    bench.ask(TRIGGER_RECORDS.query())
    records = [bytes.fromhex("41 75 35 01") + bytes((number,)) + RECORD[5:15] for number in range(1, 10)]
    for raw in records:
        bench.hear(raw + bytes((sum(raw[2:]) & 0xFF,)), after_s=0.1)
    bench.hear(STREAMED, after_s=0.1)
    bench.wait(0.5)
    (answered,) = bench.taken(Answered)
    counts = [message.boot_count for message in answered.messages if isinstance(message, TriggerRecord)]
    assert counts == list(range(1, 10))


@pytest.mark.parametrize(("gap_s", "belongs"), [(0.49, True), (0.52, False)])
def test_e06_a_record_after_half_a_second_of_silence_is_none_of_the_answer(
    bench: Bench, gap_s: float, belongs: bool
) -> None:
    bench.ask(TRIGGER_RECORDS.query())
    bench.hear(RECORD, after_s=0.1)
    bench.hear(TRAP, after_s=gap_s)
    assert bench.roles() == [Role.ANSWER, Role.ANSWER if belongs else Role.UNSOLICITED]
    bench.wait(0.6)
    (answered,) = bench.taken(Answered)
    assert len(answered.messages) == (2 if belongs else 1)


REQUESTS = [
    *(command.query() for command in COMMANDS if command.query_data is not None),
    *(Request(command, 2, raw) for command in COMMANDS if command.write for raw in sorted(command.write.allowed)[:2]),
]
LONGEST_S = 30.0
"""All attempts behind a fence, or ten seconds of records."""
MOST = 2 * TRIES


def carried(data: bytes, asked: Request) -> set[object]:
    """What the frames in these bytes say that can answer it, wherever they begin."""
    pieces = (data[at : at + layout.value] for layout in Layout for at in range(len(data)))
    frames = (raw for raw in pieces if raw[:2] == b"Au" and len(raw) > 5 and sum_is_right(raw))
    return {said(decode(raw, asked)) for raw in frames if answers(raw, asked)}


def said(message: Message) -> object:
    return type(message) if isinstance(message, Heartbeat) else message


@settings(max_examples=2000 if IS_THOROUGH else 200)
@given(st.integers(0, 2**48))
@pytest.mark.promise("b")
def test_whatever_comes_only_what_was_asked_leaves_and_only_what_came_since_is_believed(seed: int) -> None:
    bench, dice = Bench(is_there=False), random.Random(seed)
    for request in dice.choices(REQUESTS, k=dice.randint(1, 8)):
        bench.events += bench.link.abandon(bench.now)
        bench.events.clear()
        bench.begin_to_ask(request, is_deliberate=True)
        heard, ends_at = b"", bench.now + LONGEST_S
        while not (bench.link.is_idle or bench.link.is_own):
            assert bench.now < ends_at, "it does not end"
            bench.wait(dice.choice((0.0, 0.003, 0.1, 0.3)))
            replies = [raw for raw in (vector.raw for vector in FROM_MODULE) if answers(raw, request)]
            data = dice.choice([b"", hostile_bytes(dice), request.encode(), *replies, PULSE, encode_reply(0x23, 1)])
            place = dice.randint(0, len(data))
            for part in (data[:place], data[place:]):
                heard += part if bench.has_left else b""
                bench.hear(part, after_s=0.0)
            if dice.random() < 0.05:
                bench.events += bench.link.abandon(bench.now)
        sent = {event.request for event in bench.taken(Sent)}
        assert request in FENCES or bench.sent(request) <= (MOST if request.is_repeatable else 1)
        assert sent <= {request, HEARTBEAT.query(), *FENCES}
        outcomes = bench.taken(Answered) + bench.taken(Unanswered)
        assert len(outcomes) == 1
        for outcome in outcomes:
            assert outcome.request == request
            assert not isinstance(outcome, Answered) or {*map(said, outcome.messages)} <= carried(heard, request)
