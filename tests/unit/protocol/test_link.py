"""One exchange on the link: what is sent, what is believed, and what is counted."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.catalogue import COMMANDS, HEARTBEAT, LOCK, TRIGGER_RECORDS, Hazard, Layout, Request
from protocol.events import Answered, OutcomeUnknown, Role, Sent, Unanswered
from protocol.link import LinkMisused
from protocol.messages import Heartbeat, Message, Reading, TriggerRecord, answers, decode, encode_reply
from protocol.stale_replies import FENCES
from protocol.timing import TRIES
from tests.support.line.link_bench import PULSE, RECORD, STREAMED, TRAP, Bench, named
from tests.support.line.nasty_bytes import hostile_bytes
from tests.support.line.reference_decoder import sum_is_right
from tests.support.thorough import IS_THOROUGH
from tests.vendor.frames import FROM_MODULE


@pytest.fixture
def bench() -> Bench:
    return Bench().begun()


def test_a_question_is_answered_once_with_its_round_trip(bench: Bench) -> None:
    assert bench.begin_to_ask(named("attitude_threshold").query()) == bytes.fromhex("42 61 20 01 00 21")
    bench.hear(encode_reply(0x20, 60), after_s=0.004)
    (answered,) = bench.taken(Answered)
    assert answered.messages == (Reading(named("attitude_threshold"), 60),)
    assert answered.round_trip_s == pytest.approx(0.004)
    assert bench.link.is_idle


@pytest.mark.parametrize("request_", [named("freefall_time").set(1.6), named("serial_output").set(True), LOCK])
def test_a_set_goes_out_once_and_unanswered_its_outcome_is_unknown(bench: Bench, request_: Request) -> None:
    bench.ask(request_)
    bench.wait(30)
    assert [event.request for event in bench.taken(OutcomeUnknown)] == [request_]
    assert bench.sent(request_) == 1


@pytest.mark.promise("i")
@pytest.mark.parametrize("name", ["deploy", "activation", "shutdown"])
def test_a_dangerous_request_needs_an_explicit_act_and_goes_out_once(bench: Bench, name: str) -> None:
    request = named(name).set(True)
    assert request.hazard is Hazard.DANGEROUS
    with pytest.raises(LinkMisused):
        bench.link.ask(request, bench.now)
    assert bench.link.take_outgoing() == b""
    bench.ask(request, is_deliberate=True)
    bench.wait(60)
    assert bench.sent(request) == 1
    assert len(bench.taken(OutcomeUnknown)) == 1


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
        outcomes = bench.taken(Answered) + bench.taken(Unanswered) + bench.taken(OutcomeUnknown)
        assert len(outcomes) == 1
        for outcome in outcomes:
            assert outcome.request == request
            assert not isinstance(outcome, Answered) or {*map(said, outcome.messages)} <= carried(heard, request)
