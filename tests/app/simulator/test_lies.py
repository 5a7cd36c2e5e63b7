"""What each lie of the simulated module does and leaves alone; each E-number can be switched."""

import itertools
from dataclasses import fields

import pytest

from app.simulator.answers import SimulatedModule
from app.simulator.memory import Memory, invent_records
from app.simulator.physics import Physics
from app.simulator.setup import EmptySlots, Setup, parse_options
from app.simulator.wire import Wire
from protocol.catalogue import BY_NAME, STATUS, TRIGGER_RECORDS
from protocol.frame import Frame, encode_reply
from protocol.messages import EmptySlot, TriggerRecord, decode_record
from protocol.stream import StreamParser
from tests.support.line import simulated
from tests.support.line.lies import LyingModule, lies_of, lying, lying_bench
from tests.support.line.sim_line import FakeClock
from tests.support.line.simulated import receive, say, tick

SET_G_4 = "42 61 21 02 04 27"
ASK = "42 61 20 01 00 21"
SET_70 = "42 61 20 02 46 68"
SET_30 = "42 61 20 02 1e 40"
ACTIVATE = "42 61 10 02 01 13"
LOCK = "42 61 10 02 00 12"
ZERO = "42 61 25 01 00 26"
SHUT_DOWN = "42 61 12 02 01 15"
STREAM_ON = "42 61 13 02 01 16"
ASK_ACTIVE, IS_LOCKED, IS_ACTIVE = "42 61 30 01 00 31", "41 75 30 01 00 31", "41 75 30 01 01 32"
ASK_LIGHT = "42 61 14 01 01 16"
ASK_G, IS_G_5 = "42 61 21 01 00 22", "41 75 21 01 05 27"
ASK_STATUS = STATUS.query().encode()
STATUS_REPLY = bytes.fromhex("41 75 32 00 0a 00 00 3c")
BYTE_S = 10 / 115200
ASK_BOOTS, IS_37 = "42 61 23 01 00 24", "41 75 23 01 25 49"
IS_1_6_S = "41 75 22 01 a0 c3"
IS_60, IS_70, IS_30, IS_55 = "41 75 20 01 3c 5d", "41 75 20 01 46 67", "41 75 20 01 1e 3f", "41 75 20 01 37 58"


def running(**options: str) -> LyingModule:
    """A module that has been running for a minute at time 0."""
    clock = FakeClock()
    clock.now_s = 0.0
    module = lying(lying_bench({"noise": "0", "drain": "0", "empty_slots": "none"} | options, clock))
    module.collect(0.0)
    return module


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
        ({"read_changes": "23:20=1E"}, [(ASK_BOOTS, 0, IS_37), (ASK, 0, IS_30)]),
        ({"mute_codes": "20/3,14"}, [(ASK, 0, IS_60), (SET_70, 0, IS_70), (ASK, 0, ""),
                                     (SET_30, 0, ""), ("42 61 14 01 01 16", 0, "")]),
        ({"double_codes": "12"}, [(SHUT_DOWN, 0, "41 75 12 01 01 14 41 75 12 01 01 14"), (ASK, 0, "")]),
        ({"silent_restart_ms": "5", "double_codes": "20", "double_ms": "10"}, [(SET_70, 0, IS_70)]),
        ({"shuts_down": "no"}, [(SHUT_DOWN, 0, "41 75 12 01 01 14"), (ASK, 0, IS_60)]),
        ({"locks": "no"}, [(ACTIVATE, 0, "41 75 10 01 01 12"), (LOCK, 0, "41 75 10 01 00 11"),
                           (ASK_ACTIVE, 0, IS_ACTIVE)]),
        ({"activates": "no"}, [(ACTIVATE, 0, "41 75 10 01 01 12"), (ASK_ACTIVE, 0, IS_LOCKED)]),
        ({"active_late_ms": "500"}, [(ACTIVATE, 0, "41 75 10 01 01 12"), (ASK_ACTIVE, 0.49, IS_LOCKED),
                                     (STATUS.query().encode().hex(" "), 0.49, STATUS_REPLY.hex(" ")),
                                     (ASK_ACTIVE, 0.51, IS_ACTIVE), (LOCK, 1, "41 75 10 01 00 11"),
                                     (LOCK, 1.3, "41 75 10 01 00 11"), (ASK_ACTIVE, 1.49, IS_ACTIVE),
                                     (ASK_ACTIVE, 1.51, IS_LOCKED)]),
        ({"zeroes": "no", "tilt": "7"}, [(ZERO, 0, "41 75 25 01 01 27"),
                                         ("42 61 32 01 00 33", 0, "41 75 32 07 0a 00 00 43")]),
        ({"double_codes": "01,20", "double_ms": "50"}, [(ASK, 0, IS_60), (ASK_BOOTS, 0.049, IS_37),
                                                        (ASK_BOOTS, 0.051, f"{IS_60} {IS_37}")]),
        ({"foreign_replies": "20:22@500"}, [(ASK, 0, IS_60), (ASK_BOOTS, 0.499, IS_37),
                                            (ASK_BOOTS, 0.501, f"{IS_1_6_S} {IS_37}")]),
        # What the simulated module does itself
        ({"ack": "one"}, [("42 61 20 02 3c 5e", 0, IS_60), ("42 61 21 02 05 28", 0, "41 75 21 01 01 23"),
                          ("42 61 22 02 a0 c4", 0, "41 75 22 01 01 24"),
                          ("42 61 24 02 06 2c", 0, "41 75 24 01 01 26")]),
        ({"voltage_code": "34", "cell": "4"}, [("42 61 34 01 00 35", 0, "41 75 34 01 c8 fd")]),
        ({"freefall_ack": "17"}, [("42 61 17 02 01 1a", 0, "41 75 17 01 01 19")]),
        ({"light_inverted": "yes"}, [(ASK_LIGHT, 0, "41 75 14 01 19 2e")]),
        ({"light_inverted": "yes", "bay_open": "yes"}, [(ASK_LIGHT, 0, "41 75 14 01 03 18")]),
        ({"keeps": "no"}, [(SET_70, 0, IS_70), (ASK, 0, IS_60)]),
        ({"clamps": "yes"}, [(SET_30, 0, IS_55), (ASK, 0, IS_55)]),
        ({"refuses": "yes"}, [(SET_G_4, 0, IS_G_5), (ASK_G, 0, IS_G_5)]),
        ({"refuses": "yes", "ack": "one"}, [(SET_G_4, 0, "41 75 21 01 00 22"), (ASK_G, 0, IS_G_5)]),
        ({"stream": "acknowledged"}, [(STREAM_ON, 0, "41 75 13 01 01 15")]),
        ({"stream": "silent"}, [(STREAM_ON, 0, "")]),
        *(({"foreign_replies": rule}, [(ASK, 0, f"{foreign} {IS_60}")]) for rule, foreign in (
            ("20:22", IS_1_6_S), ("20:22=05", "41 75 22 01 05 28"), ("20:16", "41 75 16 01 00 17"),
            ("20:12", "41 75 12 01 01 14"), ("20:01", "41 75 01 a5 5a 00"), ("20:32", "41 75 32 00 0a 00 00 3c"),
        )),
    ],
)  # fmt: skip
def test_what_is_said_to_what(options: dict[str, str], said: list[tuple[str, float, str]]) -> None:
    module = running(**options)
    assert [(asked, at_s, say(module, asked, at_s)) for asked, at_s, _ in said] == said
    assert tick(module, 10.0) == b""


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
    parsed, memory = parse_options(options), Memory(boot_count=36)
    invent_records(memory, history, seed=1, has_odd_voltage=bool(parsed.get("odd_voltage")))
    return simulated.running(Physics(cell_v=4.0, drain_v_per_h=0.0), memory, **parsed)


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


@pytest.mark.parametrize(
    ("how", "records", "empty"), [("none", 0, 0), ("none", 2, 0), ("zeros", 0, 9), ("zeros", 2, 7), ("ones", 2, 7)]
)
def test_e7_slots_never_used(how: str, records: int, empty: int) -> None:
    raw = receive(running_module(history=records, empty_slots=how), TRIGGER_RECORDS.query().encode(), 0.0)
    kinds = [type(decode_record(piece.raw)) for piece in StreamParser().feed(raw)]
    assert kinds == [TriggerRecord] * records + [EmptySlot] * empty
    (declared,) = (field.default for field in fields(Setup) if field.name == "empty_slots")
    assert declared is EmptySlots.NONE


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


def test_a_module_that_streams_after_every_start() -> None:
    module = running_module(stream_at_boot="yes")
    assert module.is_streaming
    assert len(tick(module, 1.0)) > 40 * 8
    say(module, "42 61 13 02 00 15", 1.0)
    assert not module.is_streaming
