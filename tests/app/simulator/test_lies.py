"""What each lie of the simulated module does and leaves alone; each E-number can be switched."""

import itertools
from dataclasses import fields
from typing import Any

import pytest

from app.simulator.answers import SimulatedModule
from app.simulator.memory import Memory, invent_records
from app.simulator.physics import Physics
from app.simulator.setup import EmptySlots, Setup, parse_options
from app.simulator.wire import Wire
from protocol.catalogue import BY_CODE, BY_NAME, CELL_VOLTAGE, STATUS, TRIGGER_RECORDS, Request
from protocol.frame import Frame, encode_reply
from protocol.messages import EmptySlot, TriggerRecord, decode_record
from protocol.stream import StreamParser
from tests.support.line.lies import CHANGEABLE_CODES, LyingModule, lies_of, lying, lying_bench, read_raw
from tests.support.line.sim_line import FakeClock
from tests.support.line.simulated import booted, receive, say, tick

SET_G_4 = "42 61 21 02 04 27"
ASK = "42 61 20 01 00 21"
SET_70 = "42 61 20 02 46 68"
SET_30 = "42 61 20 02 1e 40"
DISABLE_ATTITUDE = "42 61 16 02 01 19"
ACTIVATE = "42 61 10 02 01 13"
LOCK = "42 61 10 02 00 12"
ZERO = "42 61 25 01 00 26"
SHUT_DOWN = "42 61 12 02 01 15"
ASK_STATUS = STATUS.query().encode()
STATUS_REPLY = bytes.fromhex("41 75 32 00 0a 00 00 3c")
BYTE_S = 10 / 115200
ASK_BOOTS = "42 61 23 01 00 24"
IS_60, IS_70, IS_30, IS_55 = "41 75 20 01 3c 5d", "41 75 20 01 46 67", "41 75 20 01 1e 3f", "41 75 20 01 37 58"


def running(**options: str) -> LyingModule:
    """A module that has been running for a minute at time 0."""
    clock = FakeClock()
    clock.now_s = 0.0
    module = lying(lying_bench({"noise": "0", "drain": "0", "empty_slots": "none"} | options, clock))
    module.collect(0.0)
    return module


@pytest.mark.parametrize("cause", ["15", "16", "17", "20", "21", "22", "10"])
@pytest.mark.parametrize("effect", sorted(CHANGEABLE_CODES))
def test_writing_one_setting_changes_any_other(cause: str, effect: int) -> None:
    module = running(cross_talk=f"{cause}:{effect:02X}=01")
    before = read_raw(module, effect)
    answer = receive(module, Request(BY_CODE[int(cause, 16)], 0x02, 0x00).encode(), 0.0)
    assert answer[-2] == 0x00, "the acknowledgement says nothing of it"
    assert read_raw(module, effect) == 0x01 != before or before == 0x01


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"revert_ms": "20"}, [(SET_70, 0, IS_70), (ASK, 0.019, IS_70), (ASK, 0.021, IS_60)]),
        ({"clamp_ms": "500"}, [(SET_30, 0, IS_30), (ASK, 0.49, IS_30), (ASK, 0.51, IS_55)]),
        ({"cross_talk": "21:20"}, [("42 61 21 01 00 22", 0, "41 75 21 01 05 27"), (ASK, 0, IS_60),
                                   (SET_G_4, 0, "41 75 21 01 04 26"), (ASK, 0, "41 75 20 01 04 25")]),
        ({"cross_talk": "21:20=46/2@500"}, [(SET_G_4, 0, "41 75 21 01 04 26"), (ASK, 0.9, IS_60),
                                            (SET_G_4, 1, "41 75 21 01 04 26"), (ASK, 1.499, IS_60),
                                            (ASK, 1.501, IS_70)]),
        ({"cross_talk": "25:20=1E"}, [(ZERO, 0, "41 75 25 01 01 27"), (ASK, 0, IS_30)]),
        ({"read_changes": "20:20=1E/2@50"}, [(ASK, 0, IS_60), (ASK, 0, IS_60),
                                             (ASK, 0.04, IS_60), (ASK, 0.06, IS_30)]),
        ({"read_changes": "23:20=1E"}, [(ASK_BOOTS, 0, "41 75 23 01 25 49"), (ASK, 0, IS_30)]),
        ({"mute_codes": "20/3,14"}, [(ASK, 0, IS_60), (SET_70, 0, IS_70), (ASK, 0, ""),
                                     (SET_30, 0, ""), ("42 61 14 01 01 16", 0, "")]),
        ({"double_codes": "12"}, [(SHUT_DOWN, 0, "41 75 12 01 01 14 41 75 12 01 01 14"), (ASK, 0, "")]),
        ({"silent_restart_ms": "5", "double_codes": "20", "double_ms": "10"}, [(SET_70, 0, IS_70)]),
        ({"shuts_down": "no"}, [(SHUT_DOWN, 0, "41 75 12 01 01 14"), (ASK, 0, IS_60)]),
        ({"locks": "no"}, [(ACTIVATE, 0, "41 75 10 01 01 12"), (LOCK, 0, "41 75 10 01 00 11"),
                           ("42 61 30 01 00 31", 0, "41 75 30 01 01 32")]),
        ({"activates": "no"}, [(ACTIVATE, 0, "41 75 10 01 01 12"), ("42 61 30 01 00 31", 0, "41 75 30 01 00 31")]),
        *(({"foreign_replies": rule}, [(ASK, 0, f"{foreign} {IS_60}")]) for rule, foreign in (
            ("20:22", "41 75 22 01 a0 c3"), ("20:22=05", "41 75 22 01 05 28"), ("20:16", "41 75 16 01 00 17"),
            ("20:12", "41 75 12 01 01 14"), ("20:01", "41 75 01 a5 5a 00"), ("20:32", "41 75 32 00 0a 00 00 3c"),
        )),
    ],
)  # fmt: skip
def test_what_is_said_to_what(options: dict[str, str], said: list[tuple[str, float, str]]) -> None:
    module = running(**options)
    assert [(asked, at_s, say(module, asked, at_s)) for asked, at_s, _ in said] == said
    assert tick(module, 10.0) == b""


def test_a_silent_restart_after_an_acknowledgement_and_none_after_a_query() -> None:
    module = running(silent_restart_ms="30")
    say(module, ASK_BOOTS)
    say(module, DISABLE_ATTITUDE, 0.5)
    boots = module.memory.boot_count
    assert not module.state.attitude_is_enabled
    assert tick(module, 1.0) == b"", "it says nothing of it"
    assert module.memory.boot_count == boots + 1
    assert module.state.attitude_is_enabled, "what does not survive is gone"


def test_records_are_left_out_in_the_pass_that_was_named() -> None:
    def boots(module: LyingModule) -> list[int]:
        raw = receive(module, TRIGGER_RECORDS.query().encode(), 0.0)
        return [decode_record(piece.raw).raw[4] for piece in StreamParser().feed(raw)]

    first, _, third, fourth = boots(running(history="4"))
    module = running(history="4", drop_records="1/2,2,4/1")
    assert [boots(module) for _ in range(3)] == [[first, third], [third, fourth], [first, third, fourth]]


@pytest.mark.parametrize(("after_ms", "second_s"), [("0", 0.0), ("50", 0.05)])
def test_chosen_answers_come_twice(after_ms: str, second_s: float) -> None:
    module = running(double_codes="01,20", double_ms=after_ms)
    sent = module.receive(bytes.fromhex("42 61 01 a5 5a 00"), 0.0) + module.collect(1.0)
    assert [burst.data.hex(" ") for burst in sent] == ["41 75 01 a5 5a 00"] * 2
    assert sent[1].at_s == pytest.approx(second_s, abs=0.002)
    assert len(receive(module, bytes.fromhex(ASK_BOOTS), 2.0) + tick(module, 3.0)) == 6


def test_foreign_answers_come_later_and_records_whole() -> None:
    module = running(foreign_replies="20:22@500")
    assert say(module, ASK) == IS_60
    assert (tick(module, 0.499), tick(module, 0.501).hex(" ")) == (b"", "41 75 22 01 a0 c3")
    module = running(history="1", foreign_replies="20:35")
    pieces = StreamParser().feed(receive(module, bytes.fromhex(ASK), 0.0))
    assert [len(piece.raw) for piece in pieces if isinstance(piece, Frame)] == [16, 6]


def test_the_stream_jitters_and_loses_nothing() -> None:
    def frame_times(jitter_ms: str) -> list[float]:
        module = running(stream_jitter_ms=jitter_ms)
        say(module, "42 61 13 02 01 16")
        return [sent.at_s for sent in module.collect(4.0)]

    even, uneven = frame_times("0"), frame_times("15")
    late = [after - before for before, after in zip(even, uneven, strict=False)]
    assert abs(len(even) - len(uneven)) <= 1
    assert all(-1e-9 <= late_s <= 0.0151 for late_s in late)
    assert max(late) > 0.01
    assert uneven == sorted(uneven) == frame_times("15")


def test_an_activation_is_reported_late_and_so_is_locking() -> None:
    module = running(active_late_ms="500")
    say(module, ACTIVATE)
    assert module.state.is_active
    assert [module.reports_active(at_s) for at_s in (0.0, 0.49, 0.51)] == [False, False, True]
    assert receive(module, STATUS.query().encode(), 0.4)[6] == 0x00
    say(module, LOCK, 1.0)
    say(module, LOCK, 1.3)
    assert not module.state.is_active
    assert [module.reports_active(at_s) for at_s in (1.49, 1.51)] == [True, False]


def test_zeroing_without_effect() -> None:
    module = running(zeroes="no", tilt="7")
    assert say(module, ZERO) == "41 75 25 01 01 27"
    assert module.tilt_deg(0.0) == 7


def test_lies_count_from_when_they_are_told() -> None:
    module = running()
    say(module, ASK_BOOTS)
    module.lies = lies_of({"foreign_replies": "23:22/2"})
    assert [len(receive(module, bytes.fromhex(ASK_BOOTS), 0.0)) for _ in range(3)] == [6, 12, 6]
    assert say(module, ASK_BOOTS) == encode_reply(0x23, 37).hex(" ")


def line_of(**options: str) -> Wire:
    """The line of such a module."""
    return Wire(running(**options))


@pytest.mark.parametrize(("pause_s", "is_heard"), [(0.004, False), (0.0049, False), (0.0051, True), (0.05, True)])
def test_a_request_too_soon_after_a_reply_is_ignored(pause_s: float, is_heard: bool) -> None:
    line = line_of(min_gap_ms="5")
    line.write(ASK_STATUS, 0.0)
    replied_s = 14 * BYTE_S
    assert line.read(replied_s + 1e-6) == STATUS_REPLY
    line.write(ASK_STATUS, replied_s + pause_s)
    assert line.read(1.0) == (STATUS_REPLY if is_heard else b"")


def test_a_request_too_soon_after_another_is_ignored_whether_or_not_that_was_answered() -> None:
    line = line_of(min_gap_ms="5")
    line.write(ASK_STATUS + ASK_STATUS, 0.0)
    line.write(ASK_STATUS, 0.005)
    assert line.read(0.01) == STATUS_REPLY
    line.write(ASK_STATUS, 0.02)
    assert line.read(1.0) == STATUS_REPLY
    line.module.change(mute_codes=frozenset({0x32}))
    line.write(ASK_STATUS, 1.0)
    line.write(BY_NAME["active"].query().encode(), 1.004)
    assert line.read(2.0) == b""
    line.write(BY_NAME["active"].query().encode(), 2.0)
    assert len(line.read(3.0)) == 6


def test_streamed_frames_are_no_replies_after_which_a_gap_is_needed() -> None:
    line = line_of(min_gap_ms="5")
    line.module.change(rate=200.0)
    line.module.start_stream(0.0)
    line.write(BY_NAME["charging"].query().encode(), 0.1031)
    assert line.read(0.2).count(bytes.fromhex("41 75 33 01 00 34")) == 1


def test_half_duplex_loses_what_arrives_while_the_module_sends() -> None:
    line = line_of(half_duplex="yes")
    line.write(ASK_STATUS + ASK_STATUS, 0.0)
    assert line.read(1.0) == STATUS_REPLY
    line.write(ASK_STATUS, 1.0)
    assert line.read(2.0) == STATUS_REPLY
    line.module.change(rate=200.0)
    line.module.start_stream(2.0)
    line.read(2.0101)
    line.write(BY_NAME["active"].query().encode(), 2.0148)  # the next frame begins in the middle of it
    line.write(BY_NAME["charging"].query().encode(), 2.0208)
    streamed_and_answered = line.read(2.1)
    assert b"\x41\x75\x30" not in streamed_and_answered
    assert streamed_and_answered.count(bytes.fromhex("41 75 33 01 00 34")) == 1


def running_module(*, history: int = 0, **options: str) -> SimulatedModule:
    """A module that has booted a while ago, with options as one types them."""
    setup = Setup(**parse_options(options))
    memory = Memory(boot_count=36)
    invent_records(memory, history, seed=1, has_odd_voltage=setup.odd_voltage)
    return booted(SimulatedModule(Physics(cell_v=4.0, drain_v_per_h=0.0), setup, memory=memory))


def test_e7_without_records_a_module_is_silent_unless_told_otherwise() -> None:
    (declared,) = (field.default for field in fields(Setup) if field.name == "empty_slots")
    assert declared is EmptySlots.NONE
    query = TRIGGER_RECORDS.query().encode()
    assert receive(running_module(empty_slots="none"), query, 0.0) == b""
    assert len(receive(running_module(empty_slots="zeros"), query, 0.0)) == 9 * 16


@pytest.mark.parametrize(
    ("asked", "echo", "one"),
    [
        ("42 61 20 02 3c 5e", "41 75 20 01 3c 5d", "41 75 20 01 3c 5d"),
        ("42 61 21 02 05 28", "41 75 21 01 05 27", "41 75 21 01 01 23"),
        ("42 61 22 02 a0 c4", "41 75 22 01 a0 c3", "41 75 22 01 01 24"),
        ("42 61 24 02 06 2c", "41 75 24 01 06 2b", "41 75 24 01 01 26"),
    ],
)
def test_e2_acknowledgement_by_value_or_by_one(asked: str, echo: str, one: str) -> None:
    assert say(running_module(), asked) == echo
    assert say(running_module(ack="one"), asked) == one


@pytest.mark.parametrize(("code", "answer"), [("34", "41 75 34 01 c8 fd"), ("35", "41 75 35 01 c8 fe")])
def test_e3_cell_voltage_by_either_code(code: str, answer: str) -> None:
    assert say(running_module(voltage_code=code), "42 61 34 01 00 35") == answer


@pytest.mark.parametrize(("code", "answer"), [("16", "41 75 16 01 01 18"), ("17", "41 75 17 01 01 19")])
def test_e4_acknowledgement_of_17_by_either_code(code: str, answer: str) -> None:
    module = running_module(freefall_ack=code)
    assert say(module, "42 61 17 02 01 1a") == answer
    assert not module.state.freefall_is_enabled
    assert module.state.attitude_is_enabled


def bursts(module: SimulatedModule) -> list[tuple[float, bytes]]:
    sent = module.receive(TRIGGER_RECORDS.query().encode(), 0.0)
    return [(round(one.at_s, 4), one.data) for one in sent + module.collect(10.0)]


@pytest.mark.parametrize(("how", "count"), [("together", 1), ("spaced", 9), ("pieces", 21)])
def test_e6_records_together_spaced_or_in_pieces(how: str, count: int) -> None:
    sent = bursts(running_module(history=9, records=how))
    assert len(sent) == count
    assert all(later - earlier >= 0.0199 for (earlier, _), (later, _) in itertools.pairwise(sent))
    raw = b"".join(data for _, data in sent)
    assert raw == b"".join(data for _, data in bursts(running_module(history=9)))
    assert len(raw) == 9 * 16


def test_e6_no_status_falls_between_the_pieces_of_a_record() -> None:
    module = running_module(history=9, records="pieces")
    say(module, "42 61 13 02 01 16")
    sent = receive(module, TRIGGER_RECORDS.query().encode(), 0.005) + tick(module, 2.0)
    pieces = StreamParser().feed(sent)
    assert all(isinstance(piece, Frame) for piece in pieces)
    assert {len(piece.raw) for piece in pieces} == {8, 16}


@pytest.mark.parametrize(("how", "records", "empty"), [("none", 2, 0), ("zeros", 2, 7), ("ones", 2, 7)])
def test_e7_slots_never_used(how: str, records: int, empty: int) -> None:
    raw = receive(running_module(history=2, empty_slots=how), TRIGGER_RECORDS.query().encode(), 0.0)
    frames = [decode_record(piece.raw) for piece in StreamParser().feed(raw)]
    kinds = [type(frame) for frame in frames]
    assert kinds == [TriggerRecord] * records + [EmptySlot] * empty


@pytest.mark.parametrize(
    ("how", "acknowledged_at", "afterwards", "after_restart"),
    [("old", 115200, 9600, 9600), ("new", 9600, 9600, 9600), ("restart", 115200, 115200, 9600)],
)
def test_e9_when_a_new_rate_begins(how: str, acknowledged_at: int, afterwards: int, after_restart: int) -> None:
    module = running_module(baud_ack=how)
    (sent,) = module.receive(bytes.fromhex("42 61 24 02 02 28"), 0.0)
    assert sent.baud_rate == acknowledged_at
    assert module.baud_rate == afterwards
    module.restart(1.0)
    assert module.baud_rate == after_restart


def test_e11_light_the_other_way_round() -> None:
    module = running_module(light_inverted="yes")
    assert say(module, "42 61 14 01 01 16") == "41 75 14 01 19 2e"
    module.world.bay_is_open = True
    assert say(module, "42 61 14 01 01 16") == "41 75 14 01 03 18"


def test_e12_records_with_a_voltage_that_no_cell_has() -> None:
    module = running_module(history=1, odd_voltage="yes")
    say(module, "42 61 10 02 01 13")
    say(module, "42 61 11 02 01 14")
    raw = receive(module, TRIGGER_RECORDS.query().encode(), 0.0)
    found = [decode_record(raw[at : at + 16]) for at in (0, 16)]
    assert all(isinstance(one, TriggerRecord) and one.implausible for one in found)


def test_e15_a_module_that_remembers_its_state() -> None:
    module = running_module(remembers="yes")
    for frame in ("42 61 10 02 01 13", "42 61 16 02 01 19", "42 61 13 02 01 16"):
        say(module, frame)
    module.restart(1.0)
    assert module.state.is_active
    assert not module.state.attitude_is_enabled
    assert module.is_streaming


def test_e15_a_prohibition_ends_with_deploy_activation_or_a_restart() -> None:
    for ending in ("42 61 11 02 01 14", "42 61 10 02 01 13"):
        module = running_module()
        say(module, "42 61 10 02 01 13")
        say(module, "42 61 11 02 00 13")
        assert module.state.is_forbidden
        say(module, ending)
        assert not module.state.is_forbidden
    module.restart(1.0)
    assert not module.state.is_forbidden


@pytest.mark.parametrize(
    ("quirks", "asked", "answer", "read_back"),
    [
        ({"keeps": "no"}, "42 61 20 02 46 68", "41 75 20 01 46 67", "41 75 20 01 3c 5d"),
        ({"clamps": "yes"}, "42 61 20 02 1e 40", "41 75 20 01 37 58", "41 75 20 01 37 58"),
        ({"refuses": "yes", "ack": "echo"}, "42 61 21 02 04 27", "41 75 21 01 05 27", "41 75 21 01 05 27"),
        ({"refuses": "yes", "ack": "one"}, "42 61 21 02 04 27", "41 75 21 01 00 22", "41 75 21 01 05 27"),
    ],
    ids=["does not keep", "clamps", "refuses", "refuses with a zero"],
)
def test_a_module_that_does_not_keep_what_it_is_told(
    quirks: dict[str, Any], asked: str, answer: str, read_back: str
) -> None:
    module = running_module(**quirks)
    assert say(module, asked) == answer
    assert say(module, BY_CODE[int(asked[6:8], 16)].query().encode().hex(" ")) == read_back


@pytest.mark.parametrize(("how", "answer"), [("acknowledged", "41 75 13 01 01 15"), ("silent", "")])
def test_a_module_that_will_not_stream(how: str, answer: str) -> None:
    module = running_module(stream=how)
    assert say(module, "42 61 13 02 01 16") == answer
    assert tick(module, 10.0) == b""


def test_a_module_that_streams_after_every_start() -> None:
    module = running_module(stream_at_boot="yes")
    assert module.is_streaming
    assert len(tick(module, 1.0)) > 40 * 8
    say(module, "42 61 13 02 00 15", 1.0)
    assert not module.is_streaming


def test_commands_that_it_does_not_know() -> None:
    module = running_module(mute_codes="14,34")
    assert say(module, "42 61 14 01 01 16") == ""
    assert receive(module, CELL_VOLTAGE.query().encode(), 0.0) == b""
    assert say(module, "42 61 23 01 00 24") == "41 75 23 01 25 49"
