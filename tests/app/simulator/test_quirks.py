"""Each place where the table leaves it open can be switched, by the name of its E-number."""

import itertools
from dataclasses import fields
from typing import Any

import pytest

from app.simulator.memory import Memory, invent_records
from app.simulator.module import SimulatedModule
from app.simulator.physics import Physics
from app.simulator.setup import EmptySlots, Setup, parse_options
from protocol.catalogue import BY_CODE, CELL_VOLTAGE, TRIGGER_RECORDS
from protocol.frame import Frame
from protocol.messages import EmptySlot, TriggerRecord, decode_record
from protocol.stream import StreamParser
from tests.support.line.simulated import booted, receive, say, tick


def running(*, history: int = 0, **options: str) -> SimulatedModule:
    """A module that has booted a while ago, with options as one types them."""
    setup = Setup(**parse_options(options))
    memory = Memory(boot_count=36)
    invent_records(memory, history, seed=1, has_odd_voltage=setup.odd_voltage)
    return booted(SimulatedModule(Physics(cell_v=4.0, drain_v_per_h=0.0), setup, memory=memory))


def test_e7_without_records_a_module_is_silent_unless_told_otherwise() -> None:
    (declared,) = (field.default for field in fields(Setup) if field.name == "empty_slots")
    assert declared is EmptySlots.NONE
    query = TRIGGER_RECORDS.query().encode()
    assert receive(running(empty_slots="none"), query, 0.0) == b""
    assert len(receive(running(empty_slots="zeros"), query, 0.0)) == 9 * 16


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
    assert say(running(), asked) == echo
    assert say(running(ack="one"), asked) == one


@pytest.mark.parametrize(("code", "answer"), [("34", "41 75 34 01 c8 fd"), ("35", "41 75 35 01 c8 fe")])
def test_e3_cell_voltage_by_either_code(code: str, answer: str) -> None:
    assert say(running(voltage_code=code), "42 61 34 01 00 35") == answer


@pytest.mark.parametrize(("code", "answer"), [("16", "41 75 16 01 01 18"), ("17", "41 75 17 01 01 19")])
def test_e4_acknowledgement_of_17_by_either_code(code: str, answer: str) -> None:
    module = running(freefall_ack=code)
    assert say(module, "42 61 17 02 01 1a") == answer
    assert not module.state.freefall_is_enabled
    assert module.state.attitude_is_enabled


def bursts(module: SimulatedModule) -> list[tuple[float, bytes]]:
    sent = module.receive(TRIGGER_RECORDS.query().encode(), 0.0)
    return [(round(one.at_s, 4), one.data) for one in sent + module.collect(10.0)]


@pytest.mark.parametrize(("how", "count"), [("together", 1), ("spaced", 9), ("pieces", 21)])
def test_e6_records_together_spaced_or_in_pieces(how: str, count: int) -> None:
    sent = bursts(running(history=9, records=how, record_gap_ms="30"))
    assert len(sent) == count
    assert all(later - earlier >= 0.0299 for (earlier, _), (later, _) in itertools.pairwise(sent))
    raw = b"".join(data for _, data in sent)
    assert raw == b"".join(data for _, data in bursts(running(history=9)))
    assert len(raw) == 9 * 16


def test_e6_no_status_falls_between_the_pieces_of_a_record() -> None:
    module = running(history=9, records="pieces")
    say(module, "42 61 13 02 01 16")
    sent = receive(module, TRIGGER_RECORDS.query().encode(), 0.005) + tick(module, 2.0)
    pieces = StreamParser().feed(sent)
    assert all(isinstance(piece, Frame) for piece in pieces)
    assert {len(piece.raw) for piece in pieces} == {8, 16}


@pytest.mark.parametrize(("how", "records", "empty"), [("none", 2, 0), ("zeros", 2, 7), ("ones", 2, 7)])
def test_e7_slots_never_used(how: str, records: int, empty: int) -> None:
    raw = receive(running(history=2, empty_slots=how), TRIGGER_RECORDS.query().encode(), 0.0)
    frames = [decode_record(piece.raw) for piece in StreamParser().feed(raw)]
    kinds = [type(frame) for frame in frames]
    assert kinds == [TriggerRecord] * records + [EmptySlot] * empty


@pytest.mark.parametrize(
    ("how", "acknowledged_at", "afterwards", "after_restart"),
    [("old", 115200, 9600, 9600), ("new", 9600, 9600, 9600), ("restart", 115200, 115200, 9600)],
)
def test_e9_when_a_new_rate_begins(how: str, acknowledged_at: int, afterwards: int, after_restart: int) -> None:
    module = running(baud_ack=how)
    (sent,) = module.receive(bytes.fromhex("42 61 24 02 02 28"), 0.0)
    assert sent.baud_rate == acknowledged_at
    assert module.baud_rate == afterwards
    module.restart(1.0)
    assert module.baud_rate == after_restart


def test_e11_light_the_other_way_round() -> None:
    module = running(light_inverted="yes")
    assert say(module, "42 61 14 01 01 16") == "41 75 14 01 19 2e"
    module.world.bay_is_open = True
    assert say(module, "42 61 14 01 01 16") == "41 75 14 01 03 18"


def test_e12_records_with_a_voltage_that_no_cell_has() -> None:
    module = running(history=1, odd_voltage="yes")
    say(module, "42 61 10 02 01 13")
    say(module, "42 61 11 02 01 14")
    raw = receive(module, TRIGGER_RECORDS.query().encode(), 0.0)
    found = [decode_record(raw[at : at + 16]) for at in (0, 16)]
    assert all(isinstance(one, TriggerRecord) and one.implausible for one in found)


def test_e15_a_module_that_remembers_its_state() -> None:
    module = running(remembers="yes")
    for frame in ("42 61 10 02 01 13", "42 61 16 02 01 19", "42 61 13 02 01 16"):
        say(module, frame)
    module.restart(1.0)
    assert module.state.is_active
    assert not module.state.attitude_is_enabled
    assert module.is_streaming


def test_e15_a_prohibition_ends_with_deploy_activation_or_a_restart() -> None:
    for ending in ("42 61 11 02 01 14", "42 61 10 02 01 13"):
        module = running()
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
    module = running(**quirks)
    assert say(module, asked) == answer
    assert say(module, BY_CODE[int(asked[6:8], 16)].query().encode().hex(" ")) == read_back


@pytest.mark.parametrize(("how", "answer"), [("acknowledged", "41 75 13 01 01 15"), ("silent", "")])
def test_a_module_that_will_not_stream(how: str, answer: str) -> None:
    module = running(stream=how)
    assert say(module, "42 61 13 02 01 16") == answer
    assert tick(module, 10.0) == b""


def test_a_module_that_streams_after_every_start() -> None:
    module = running(stream_at_boot="yes")
    assert module.is_streaming
    assert len(tick(module, 1.0)) > 40 * 8
    say(module, "42 61 13 02 00 15", 1.0)
    assert not module.is_streaming


def test_commands_that_it_does_not_know() -> None:
    module = running(mute_codes="14,34")
    assert say(module, "42 61 14 01 01 16") == ""
    assert receive(module, CELL_VOLTAGE.query().encode(), 0.0) == b""
    assert say(module, "42 61 23 01 00 24") == "41 75 23 01 25 49"
