"""The simulated module: what fires it, its records and its options. What it answers: the tests of all that asks it."""

from math import inf
from typing import Any

import pytest

from app.simulator.module import Memory, Physics, SimulatedModule
from app.simulator.setup import Setup, parse_options
from app.text.messages import UserError
from protocol.catalogue import HEARTBEAT_REPLY, TRIGGER_RECORDS
from protocol.messages import TriggerRecord, decode_record


def running(world: Physics | None = None, memory: Memory | None = None, **options: Any) -> SimulatedModule:
    """A module that was switched on a minute before time 0."""
    module = SimulatedModule(world or Physics(), Setup(**options), memory=memory)
    module.power_on(-60.0)
    tick(module, 0.0)
    return module


def receive(module: SimulatedModule, data: bytes, now_s: float) -> bytes:
    """What it sends by now, ignoring the baud rate."""
    module.receive(data, now_s)
    return tick(module, now_s)


def tick(module: SimulatedModule, now_s: float) -> bytes:
    """Bytes that are due by now."""
    module.advance(now_s)
    said = b"".join(sent.data for sent in module.out)
    module.out.clear()
    return said


def say(module: SimulatedModule, frame: str, now_s: float = 0.0) -> str:
    """The replies to `frame`, in hexadecimal."""
    return receive(module, bytes.fromhex(frame), now_s).hex(" ")


def records(module: SimulatedModule, now_s: float) -> list[TriggerRecord]:
    raw = receive(module, TRIGGER_RECORDS.query().encode(), now_s)
    found = [decode_record(raw[at : at + 16]) for at in range(0, len(raw), 16)]
    assert len(found) == 9
    return [one for one in found if isinstance(one, TriggerRecord)]


def test_two_heartbeats_50_ms_apart_after_power_up_and_then_silence() -> None:
    module = SimulatedModule(Physics())
    module.power_on(10.0)
    assert tick(module, 10.0) == HEARTBEAT_REPLY
    assert tick(module, 10.049) == b""
    assert module.due_s == pytest.approx(10.05)
    assert tick(module, 10.06) == HEARTBEAT_REPLY
    assert tick(module, 3600.0) == b""
    assert module.due_s == inf


def test_17_is_acknowledged_as_the_table_prints_it() -> None:
    """E4."""
    assert say(running(), "42 61 17 02 01 1a") == "41 75 16 01 01 18"


def test_a_locked_module_does_not_fire_over_serial() -> None:
    module = running()
    assert say(module, "42 61 11 02 01 14", 1.0) == "41 75 11 01 00 12"
    assert not module.is_triggered


def test_a_drop_of_20_m_fires_by_free_fall_and_a_low_one_does_not() -> None:
    module = running()
    say(module, "42 61 10 02 01 13")
    module.world.drop(10, 0.0)
    tick(module, 5.0)
    assert not module.is_triggered
    module.world.drop(20, 5.0)
    tick(module, 10.0)
    assert [record.sources for record in records(module, 10.0)] == [("freefall",)]
    assert module.is_triggered
    assert say(module, "42 61 10 02 00 12", 10.0)
    assert not module.is_triggered


def test_a_record_holds_the_settings_and_readings_of_its_moment() -> None:
    module = running(Physics(cell_v=4.0))
    for frame in ("42 61 20 02 46 68", "42 61 21 02 04 27", "42 61 22 02 64 88", "42 61 10 02 01 13"):
        say(module, frame)
    module.world.has_external_power = True
    module.world.tilt_deg = 75
    tick(module, 9.0)
    module.world.tilt_deg = 0
    say(module, "42 61 20 02 3c 5e", 50.0)
    (record,) = records(module, 50.0)
    assert record.attitude_threshold_deg == 70
    assert record.freefall_acceleration_g == 0.4
    assert record.freefall_time_s == 1.0
    assert record.charging
    assert (record.light_v, module.world.bay_is_open) == (0.3, True), "it was still closed"
    assert record.cell_voltage_v == pytest.approx(4.1)
    assert record.serial_connected
    tick(module, 90.0)
    module.world.tilt_deg = 75
    tick(module, 99.0)
    assert not records(module, 300.0)[-1].serial_connected, "nobody had asked for more than 30 s"


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("rate", "0", ">= 1.0"),
        ("drop", "nan", "0.0"),
        ("baud", "1234", "1234"),
        ("active", "maybe", "bool"),
    ],
)
def test_a_wrong_value_is_refused_with_what_is_possible(name: str, text: str, said: str) -> None:
    with pytest.raises(UserError, match=name) as refused:
        parse_options({name: text})
    assert said in str(refused.value)
