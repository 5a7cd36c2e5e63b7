"""The link on a fake clock: what is sent, what is believed, and when it gives up."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.catalogue import COMMANDS, HEARTBEAT, TRIGGER_RECORDS, Hazard, Layout, Request
from protocol.events import (
    Answered,
    OutcomeUnknown,
    Received,
    Rejected,
    Role,
    Sent,
    Unanswered,
    WentOffline,
    WentOnline,
)
from protocol.frame import encode_reply
from protocol.link import LinkMisused
from protocol.link_states import EXCHANGE, Exchange, Presence, Step
from protocol.messages import Heartbeat, Message, Reading, TriggerRecord, answers, decode
from protocol.stale_replies import FENCES
from tests.support.line.link_bench import PULSE, RECORD, STREAMED, TRAP, Bench, named
from tests.support.line.nasty_bytes import hostile_bytes
from tests.support.line.reference_decoder import sum_is_right
from tests.support.thorough import IS_THOROUGH
from tests.vendor.frames import BY_ID, FROM_MODULE


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_question_is_answered_once_with_its_round_trip(bench: Bench) -> None:
    assert bench.ask(named("attitude_threshold").query()) == bytes.fromhex("42 61 20 01 00 21")
    bench.hear(encode_reply(0x20, 60), after_s=0.004)
    (answered,) = bench.taken(Answered)
    assert answered.messages == (Reading(named("attitude_threshold"), 60),)
    assert answered.round_trip_s == pytest.approx(0.004)
    assert bench.link.is_idle
    assert bench.link.presence is Presence.ONLINE
    assert len(bench.taken(WentOnline)) == 1


def test_the_first_question_waits_the_vendors_second_three_times(bench: Bench) -> None:
    first = bench.ask(named("boot_count").query())
    assert bench.wait(0.999) == b""
    assert bench.wait(0.04) == first
    bench.wait(2.1)
    (given_up,) = bench.taken(Unanswered)
    assert (given_up.attempts, given_up.waited_s) == (3, 1.0)
    assert [event.attempt for event in bench.taken(Sent)] == [1, 2, 3]
    assert bench.link.counters.time_outs == 3
    assert bench.link.counters.retries == 2


def test_measured_round_trips_shorten_all_waits_but_the_last(bench: Bench) -> None:
    bench.warm_up()
    bench.ask(named("boot_count").query())
    started = bench.now
    bench.wait(3)
    (given_up,) = bench.taken(Unanswered)
    assert given_up.waited_s == 1.0
    assert given_up.at - started == pytest.approx(0.15 + 0.03 + 0.3 + 0.03 + 1.0, abs=0.01)


def test_an_answer_to_a_repeated_question_is_no_round_trip(bench: Bench) -> None:
    bench.ask(named("boot_count").query())
    bench.wait(1.05)
    bench.hear(encode_reply(0x23, 37))
    (answered,) = bench.taken(Answered)
    assert (answered.attempts, answered.round_trip_s) == (2, None)
    bench.hear(encode_reply(0x23, 37), after_s=0.5)
    assert bench.roles() == [Role.ANSWER, Role.LATE]


@pytest.mark.parametrize(
    "request_",
    [named("freefall_time").set(1.6), named("serial_output").set(True), named("activation").set(False)],
)
def test_a_set_goes_out_once_and_unanswered_its_outcome_is_unknown(bench: Bench, request_: Request) -> None:
    bench.ask(request_)
    assert request_.encode() not in bench.wait(30)
    assert [type(event) for event in bench.taken(OutcomeUnknown)] == [OutcomeUnknown]
    assert sum(event.request == request_ for event in bench.taken(Sent)) == 1


@pytest.mark.parametrize(("name", "waited_s"), [("light_threshold", [0.5]), ("light", [])])
def test_what_is_abandoned_is_of_unknown_outcome_if_it_may_have_changed_something(
    bench: Bench, name: str, waited_s: list[float]
) -> None:
    bench.ask(named(name).set(2.0) if waited_s else named(name).query())
    bench.wait(0.5)
    unknown = bench.link.abandon(bench.now)
    assert [(type(event), event.waited_s, event.at) for event in unknown if isinstance(event, OutcomeUnknown)] == [
        (OutcomeUnknown, waited, bench.now) for waited in waited_s
    ]
    assert len(unknown) == len(waited_s)


def test_a_lock_beside_the_request_in_flight_is_sent_and_counted(bench: Bench) -> None:
    bench.ask(named("light").query())
    before, lock = bench.link.counters.copy(), named("activation").set(False)
    assert bench.link.lock_again(bench.now, 2) == [Sent(lock.encode(), lock, 2, bench.now)]
    assert bench.link.take_outgoing() == lock.encode()
    counters = bench.link.counters
    assert (counters.sent, counters.retries) == (before.sent + 1, before.retries + 1)
    bench.hear(encode_reply(lock.command.code, 1))
    assert bench.roles() == [Role.LATE], "nobody waits for it"


def test_what_is_no_frame_is_told_with_its_bytes(bench: Bench) -> None:
    bench.hear(b"AT\r")
    bench.wait(1)
    assert b"".join(event.noise.raw for event in bench.taken(Rejected)) == b"AT\r"


def test_after_its_answer_a_voltage_is_no_longer_expected(bench: Bench) -> None:
    bench.ask(named("cell_voltage").query())
    bench.hear(encode_reply(0x35, 0xC8))
    bench.hear(TRAP)
    *_, heard = bench.taken(Received)
    assert isinstance(heard.message, TriggerRecord)


@pytest.mark.promise("i")
def test_a_dangerous_request_needs_an_explicit_act_and_goes_out_once(bench: Bench) -> None:
    deploy = named("deploy").set(True)
    assert deploy.hazard is Hazard.DANGEROUS
    with pytest.raises(LinkMisused):
        bench.ask(deploy)
    assert bench.link.take_outgoing() == b""
    assert bench.ask(deploy, is_deliberate=True, waits_s=(0.1, 0.1, 0.1)) == bytes.fromhex("42 61 11 02 01 14")
    assert deploy.encode() not in bench.wait(60)
    assert len(bench.taken(OutcomeUnknown)) == 1


def test_a_second_request_in_flight_is_a_bug(bench: Bench) -> None:
    bench.ask(named("light").query())
    with pytest.raises(LinkMisused):
        bench.ask(named("light").query())


@pytest.mark.parametrize("cut", range(1, 16))
def test_e03_a_record_that_begins_like_a_voltage_stays_a_record(bench: Bench, cut: int) -> None:
    bench.ask(TRIGGER_RECORDS.query())
    bench.hear(TRAP[:cut], after_s=0.003)
    bench.hear(TRAP[cut:], after_s=0.1)
    bench.wait(1)
    (answered,) = bench.taken(Answered)
    assert [type(message) for message in answered.messages] == [TriggerRecord]


def test_e06_all_records_until_the_line_is_quiet_in_order(bench: Bench) -> None:
    bench.ask(TRIGGER_RECORDS.query())
    records = [bytes.fromhex("41 75 35 01") + bytes((number,)) + RECORD[5:15] for number in range(1, 10)]
    for raw in records:
        total = sum(raw[2:]) & 0xFF
        bench.hear(raw + bytes((total,)), after_s=0.3)
    bench.hear(STREAMED, after_s=0.1)
    bench.wait(0.5)
    (answered,) = bench.taken(Answered)
    counts = [message.boot_count for message in answered.messages if isinstance(message, TriggerRecord)]
    assert counts == list(range(1, 10))


@pytest.mark.parametrize(("gap_s", "belongs"), [(0.49, True), (0.51, False)])
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


def test_e06_records_that_do_not_end_are_collected_for_ten_seconds(bench: Bench) -> None:
    bench.ask(TRIGGER_RECORDS.query())
    for _ in range(30):
        bench.hear(RECORD, after_s=0.4)
    (answered,) = bench.taken(Answered)
    assert len(answered.messages) == 25, "ten seconds from the first"


def test_e06_no_record_at_all_is_unanswered_and_asked_only_once(bench: Bench) -> None:
    bench.ask(TRIGGER_RECORDS.query())
    assert TRIGGER_RECORDS.query().encode() not in bench.wait(5)
    (given_up,) = bench.taken(Unanswered)
    assert given_up.attempts == 1


@pytest.mark.promise("j")
def test_locking_waits_behind_no_fence(bench: Bench) -> None:
    lock = named("activation").set(False)
    bench.ask(lock)
    bench.wait(1.01)
    assert bench.ask(lock) == lock.encode()


def test_a_heartbeat_goes_out_only_when_nothing_else_proves_the_link(bench: Bench) -> None:
    bench.warm_up()
    for _ in range(30):
        bench.hear(STREAMED, after_s=1)
    assert bench.taken(Sent) == []
    assert bench.wait(10.01) == HEARTBEAT.query().encode()


def test_an_unanswered_heartbeat_is_offline_and_any_frame_is_online_again(bench: Bench) -> None:
    bench.warm_up()
    bench.wait(11.01)
    assert bench.link.presence is Presence.OFFLINE
    assert len(bench.taken(WentOffline)) == 1
    assert bench.wait(2.01) == HEARTBEAT.query().encode()
    bench.hear(PULSE)
    assert bench.link.presence is Presence.ONLINE


def test_a_lost_heartbeat_is_not_offline_while_other_frames_come(bench: Bench) -> None:
    bench.warm_up()
    bench.ask(HEARTBEAT.query(), waits_s=(1.0,))
    bench.hear(STREAMED, after_s=0.5)
    bench.wait(0.6)
    assert bench.taken(WentOffline) == []
    assert bench.link.presence is Presence.ONLINE


def test_a_single_attempt_is_short_and_not_repeated(bench: Bench) -> None:
    bench.warm_up()
    light = named("light").query()
    bench.ask(light, attempts=1)
    start = bench.now
    assert light.encode() not in bench.wait(0.2)
    (given_up,) = bench.taken(Unanswered)
    assert given_up.at - start == pytest.approx(0.15)


def test_an_unanswered_question_makes_the_link_look_soon(bench: Bench) -> None:
    bench.warm_up()
    bench.ask(named("light").query(), waits_s=(0.2,))
    assert bench.wait(0.35) == HEARTBEAT.query().encode()


def test_our_own_bytes_are_an_echo_and_prove_nothing(bench: Bench) -> None:
    sent = bench.ask(HEARTBEAT.query(), waits_s=(1.0,))
    bench.hear(sent)
    bench.wait(1.1)
    assert bench.roles() == [Role.ECHO]
    assert bench.link.presence is Presence.OFFLINE


def test_a_status_is_an_answer_when_asked_and_streamed_when_not(bench: Bench) -> None:
    bench.ask(named("status").query())
    bench.hear(STREAMED)
    bench.hear(STREAMED, after_s=0.1)
    assert bench.roles() == [Role.ANSWER, Role.STREAMED]


def test_rejected_bytes_are_counted_by_reason(bench: Bench) -> None:
    bench.hear(BY_ID["attitude-threshold-reply-misprint"].raw, b"\xff\xfe")
    bench.wait(0.3)
    counted = {reason.value: count for reason, count in bench.link.counters.rejected_bytes.items()}
    assert counted == {"checksum": 6, "no_header": 2}
    assert bench.link.counters.frames == 0


def test_every_valid_frame_is_counted(bench: Bench) -> None:
    bench.hear(PULSE, STREAMED, STREAMED)
    assert bench.link.counters.frames == 3
    roles = bench.link.counters.by_role
    assert (roles[Role.STREAMED], sum(roles.values())) == (2, 3)


def test_a_heartbeat_that_answers_is_a_heartbeat(bench: Bench) -> None:
    bench.ask(HEARTBEAT.query())
    bench.hear(PULSE)
    (answered,) = bench.taken(Answered)
    assert [type(message) for message in answered.messages] == [Heartbeat]


@pytest.mark.promise("b")
def test_every_state_can_be_left_for_idle() -> None:
    for state in Exchange:
        assert EXCHANGE[state, Step.ABANDON] is Exchange.IDLE
        reachable, frontier = {state}, [state]
        while frontier:
            here = frontier.pop()
            for (source, _), target in EXCHANGE.items():
                if source is here and target not in reachable:
                    reachable.add(target)
                    frontier.append(target)
        assert Exchange.IDLE in reachable


def test_the_rest_of_a_frame_that_never_comes_is_given_up_when_the_line_is_quiet(bench: Bench) -> None:
    bench.hear(STREAMED[:4])
    assert bench.link.next_deadline() == pytest.approx(bench.now + bench.link.timing.quiet_s)
    bench.wait(bench.link.timing.quiet_s + 0.001)
    assert bench.link.counters.rejected == 4


def test_abandoning_what_waits_behind_a_fence_leaves_nothing_to_send(bench: Bench) -> None:
    activate = named("activation").set(True)
    bench.ask(named("activation").set(False))
    bench.wait(1.01)
    assert bench.ask(activate, is_deliberate=True) == HEARTBEAT.query().encode()
    bench.link.abandon(bench.now)
    assert bench.ask(HEARTBEAT.query()) == HEARTBEAT.query().encode()
    assert bench.hear(PULSE) == b""
    assert bench.link.is_idle


def test_a_reply_that_began_before_the_second_attempt_is_believed(bench: Bench) -> None:
    reply = encode_reply(0x14, 3)
    bench.ask(named("light").query())
    bench.hear(reply[:4], after_s=0.999)
    assert bench.wait(0.04) == named("light").query().encode()
    bench.hear(reply[4:])
    (answered,) = bench.taken(Answered)
    assert answered.messages == (Reading(named("light"), 3),)


def test_long_after_its_acknowledgement_a_set_is_still_read_back_behind_a_fence(bench: Bench) -> None:
    """A copy of it may come at any time, until a later request is answered."""
    bench.warm_up()
    bench.ask(named("freefall_time").set(1.8))
    bench.hear(encode_reply(0x22, 180))
    bench.wait(2.0)
    assert bench.ask(named("freefall_time").query()) != named("freefall_time").query().encode()


REQUESTS = [
    *(command.query() for command in COMMANDS if command.query_data is not None),
    *(Request(command, 2, raw) for command in COMMANDS if command.write for raw in sorted(command.write.allowed)[:2]),
]
LONGEST_S = 30.0
"""Three attempts behind a fence of three, or ten seconds of records."""


def carried(data: bytes, asked: Request) -> set[object]:
    """What the frames in these bytes say that can answer it, wherever they begin."""
    pieces = (data[at : at + layout.value] for layout in Layout for at in range(len(data)))
    frames = (raw for raw in pieces if raw[:2] == b"Au" and len(raw) > 5 and sum_is_right(raw))
    return {said(decode(raw, asked)) for raw in frames if answers(raw, asked)}


def said(message: Message) -> object:
    return type(message) if isinstance(message, Heartbeat) else message


@settings(max_examples=2000 if IS_THOROUGH else 300)
@given(st.integers(0, 2**48))
def test_whatever_comes_only_what_was_asked_leaves_and_only_what_came_since_is_believed(seed: int) -> None:
    bench, dice = Bench(), random.Random(seed)
    for request in dice.choices(REQUESTS, k=dice.randint(1, 8)):
        bench.events.clear()
        sent, heard, ends_at = bench.ask(request, is_deliberate=True), b"", bench.now + LONGEST_S
        is_abandoned = False
        while not bench.link.is_idle:
            assert bench.now < ends_at, "it does not end"
            sent += bench.wait(dice.choice((0.0, 0.003, 0.1, 0.9)))
            replies = [raw for raw in (vector.raw for vector in FROM_MODULE) if answers(raw, request)]
            data = dice.choice([b"", hostile_bytes(dice), request.encode(), *replies, PULSE])
            place = dice.randint(0, len(data))
            for part in (data[:place], data[place:]):
                heard += part if bench.link.has_left else b""
                sent += bench.hear(part, after_s=0.0)
            if dice.random() < 0.05:
                bench.events += bench.link.abandon(bench.now)
                is_abandoned = True
        frames = [sent[at : at + 6] for at in range(0, len(sent), 6)]
        assert request in FENCES or frames.count(request.encode()) <= (3 if request.is_repeatable else 1)
        assert {*frames} <= {request.encode(), *(fence.encode() for fence in FENCES)}
        ends = [one for one in bench.events if isinstance(one, Answered | Unanswered | OutcomeUnknown)]
        assert len(ends) == 1 or (is_abandoned and not ends)
        for end in ends:
            assert end.request == request
            assert not isinstance(end, Answered) or {*map(said, end.messages)} <= carried(heard, request)
