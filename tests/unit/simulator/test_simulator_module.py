"""The simulated module against the vendor's table: frames, power, triggers, records."""

import pytest

from app.simulator.module import Memory, Physics, SimulatedModule
from protocol.catalogue import TRIGGER_RECORDS
from protocol.messages import Frame, Source, Status, TriggerRecord, decode, decode_record
from protocol.stream import StreamParser
from tests.support.line.simulated import receive, running, say, tick

HEARTBEAT_REPLY = "41 75 01 a5 5a 00"


def records(module: SimulatedModule, now_s: float) -> list[TriggerRecord]:
    raw = receive(module, TRIGGER_RECORDS.query().encode(), now_s)
    found = [decode_record(raw[at : at + 16]) for at in range(0, len(raw), 16)]
    assert len(found) == 9
    return [one for one in found if isinstance(one, TriggerRecord)]


@pytest.mark.parametrize(
    ("asked", "answered"),
    [
        ("42 61 01 a5 5a 00", HEARTBEAT_REPLY),
        ("42 61 10 02 01 13", "41 75 10 01 01 12"),
        ("42 61 10 02 00 12", "41 75 10 01 00 11"),
        ("42 61 11 02 00 13", "41 75 11 01 00 12"),
        ("42 61 12 02 01 15", "41 75 12 01 01 14"),
        ("42 61 13 02 01 16", "41 75 13 01 01 15"),
        ("42 61 13 02 00 15", "41 75 13 01 00 14"),
        ("42 61 14 01 01 16", "41 75 14 01 03 18"),
        ("42 61 15 02 12 29", "41 75 15 01 12 28"),
        ("42 61 15 01 00 16", "41 75 15 01 12 28"),
        ("42 61 20 02 3c 5e", "41 75 20 01 3c 5d"),
        ("42 61 20 01 00 21", "41 75 20 01 3c 5d"),
        ("42 61 21 02 05 28", "41 75 21 01 05 27"),
        ("42 61 21 01 00 22", "41 75 21 01 05 27"),
        ("42 61 22 02 a0 c4", "41 75 22 01 a0 c3"),
        ("42 61 22 01 00 23", "41 75 22 01 a0 c3"),
        ("42 61 23 01 00 24", "41 75 23 01 01 25"),
        ("42 61 24 02 06 2c", "41 75 24 01 06 2b"),
        ("42 61 30 01 00 31", "41 75 30 01 00 31"),
        ("42 61 31 01 00 32", "41 75 31 01 00 32"),
        ("42 61 32 01 00 33", "41 75 32 00 0a 00 00 3c"),
        ("42 61 33 01 00 34", "41 75 33 01 00 34"),
        ("42 61 34 01 00 35", "41 75 35 01 be f4"),
        ("42 61 16 02 01 19", "41 75 16 01 01 18"),
        ("42 61 16 02 00 18", "41 75 16 01 00 17"),
        ("42 61 17 02 01 1a", "41 75 16 01 01 18"),
        ("42 61 17 02 00 19", "41 75 16 01 00 17"),
        ("42 61 25 01 00 26", "41 75 25 01 01 27"),
    ],
)
def test_each_row_of_the_table(asked: str, answered: str) -> None:
    assert say(running(Physics(cell_v=3.8)), asked) == answered


def test_two_heartbeats_50_ms_apart_after_power_up_and_then_silence() -> None:
    module = SimulatedModule(Physics())
    module.power_on(10.0)
    assert tick(module, 10.0).hex(" ") == HEARTBEAT_REPLY
    assert tick(module, 10.049) == b""
    assert module.next_due(10.049) == pytest.approx(10.05)
    assert tick(module, 10.06).hex(" ") == HEARTBEAT_REPLY
    assert tick(module, 3600.0) == b""
    assert module.next_due(3600.0) is None


def test_boot_count_wraps_to_0_after_255() -> None:
    module = running(memory=Memory(boot_count=254))
    assert module.memory.boot_count == 255
    module.restart(1.0)
    assert say(module, "42 61 23 01 00 24", 2.0).endswith("41 75 23 01 00 24")


def test_settings_survive_a_restart_and_the_rest_does_not() -> None:
    module = running()
    for frame in ("42 61 20 02 46 68", "42 61 10 02 01 13", "42 61 13 02 01 16", "42 61 16 02 01 19"):
        assert say(module, frame)
    module.restart(1.0)
    tick(module, 2.0)
    assert say(module, "42 61 20 01 00 21", 2.0) == "41 75 20 01 46 67"
    assert say(module, "42 61 30 01 00 31", 2.0) == "41 75 30 01 00 31"
    assert module.state.attitude_is_enabled
    assert not module.is_streaming


def test_external_power_wakes_it_after_shutdown() -> None:
    module = running()
    say(module, "42 61 12 02 01 15")
    module.set_charger(1.0, is_plugged_in=True)
    assert module.is_on
    assert say(module, "42 61 33 01 00 34", 2.0).endswith("41 75 33 01 01 35")


def test_a_new_baud_rate_holds_behind_its_acknowledgement() -> None:
    module = running()
    module.receive(bytes.fromhex("42 61 24 02 02 28 42 61 23 01 00 24"), 0.0)
    assert [sent.baud_rate for sent in module.collect(1.0)] == [115200, 9600]
    module.restart(2.0)
    assert module.baud_rate == 9600


def test_the_stream_keeps_its_rate_and_ends() -> None:
    module = running()
    module.change(rate=100)
    say(module, "42 61 13 02 01 16")
    frames = StreamParser().feed(tick(module, 2.005))
    assert len(frames) == 200
    assert {decode(frame.raw) for frame in frames if isinstance(frame, Frame)} == {Status(0, 1.0, False, False)}
    assert say(module, "42 61 13 02 00 15", 2.006) == "41 75 13 01 00 14"
    assert tick(module, 10.0) == b""


def test_tilting_an_active_module_fires_and_it_resets_ten_degrees_below() -> None:
    module = running()
    say(module, "42 61 10 02 01 13")
    module.world.tilt_deg = 60
    assert say(module, "42 61 32 01 00 33", 1.0) == "41 75 32 3c 0a 01 01 7a"
    module.world.tilt_deg = 51
    assert say(module, "42 61 31 01 00 32", 2.0) == "41 75 31 01 01 33"
    module.world.tilt_deg = 50
    assert say(module, "42 61 31 01 00 32", 3.0) == "41 75 31 01 00 32"
    assert [record.sources for record in records(module, 4.0)] == [("attitude",)]


def test_a_locked_module_does_not_fire_and_forgets() -> None:
    module = running(Physics(tilt_deg=90))
    module.world.drop(100, 0.0)
    assert say(module, "42 61 11 02 01 14") == "41 75 11 01 00 12"
    tick(module, 10.0)
    assert records(module, 10.0) == []
    assert not module.is_triggered
    say(module, "42 61 10 02 01 13", 11.0)
    tick(module, 12.0)
    assert [record.sources for record in records(module, 12.0)] == [("attitude",)], "it has not judged that before"
    module.restart(13.0)
    say(module, "42 61 10 02 01 13", 14.0)
    tick(module, 15.0)
    assert len(records(module, 15.0)) == 2


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


def test_the_parachute_ends_a_fall() -> None:
    module = running()
    say(module, "42 61 10 02 01 13")
    module.world.drop(100, 0.0)
    measured_g = []
    for number in range(1, 31):
        tick(module, number / 10)
        measured_g.append(round(module.measure(number / 10).acceleration_g, 1))
    assert measured_g == [0.0] * 18 + [3.2] + [1.0] * 11, "it fires after 1.6 s, and the parachute needs 0.2 s"


@pytest.mark.parametrize("frame", ["42 61 16 02 01 19", "42 61 11 02 00 13"])
def test_a_disabled_or_forbidden_attitude_trigger_does_not_fire(frame: str) -> None:
    module = running()
    say(module, "42 61 10 02 01 13")
    say(module, frame)
    module.world.tilt_deg = 90
    tick(module, 1.0)
    assert not module.is_triggered


def test_what_is_forbidden_does_not_fire_by_its_pwm_input_either() -> None:
    module = running()
    say(module, "42 61 10 02 01 13")
    say(module, "42 61 11 02 00 13")
    assert not module.fire(Source.PWM, 1.0)
    say(module, "42 61 10 02 01 13")
    assert module.fire(Source.PWM, 2.0)


def test_deploy_over_serial_fires_an_active_module() -> None:
    module = running()
    say(module, "42 61 10 02 01 13")
    assert say(module, "42 61 11 02 01 14", 48.0) == "41 75 11 01 01 13"
    assert say(module, "42 61 31 01 00 32", 48.0) == "41 75 31 01 01 33"
    assert module.world.bay_is_open
    (record,) = records(module, 49.0)
    assert record.sources == ("serial",)
    assert record.serial_connected
    assert (record.boot_count, record.uptime_s) == (1, 108)


def test_a_record_holds_the_settings_and_readings_of_its_moment() -> None:
    module = running(Physics(cell_v=4.0))
    for frame in ("42 61 20 02 46 68", "42 61 21 02 04 27", "42 61 22 02 64 88", "42 61 10 02 01 13"):
        say(module, frame)
    module.set_charger(1.0, is_plugged_in=True)
    module.world.tilt_deg = 75
    tick(module, 9.0)
    module.world.tilt_deg = 0
    say(module, "42 61 20 02 3c 5e", 50.0)
    (record,) = records(module, 50.0)
    assert record.attitude_threshold_deg == 70
    assert record.freefall_acceleration_g == 0.4
    assert record.freefall_time_s == 1.0
    assert record.charging
    assert record.light_v == 0.3, "the bay was still closed"
    assert record.cell_voltage_v == pytest.approx(4.1)
    assert record.serial_connected
    tick(module, 90.0)
    module.world.tilt_deg = 75
    tick(module, 99.0)
    assert not records(module, 300.0)[-1].serial_connected, "nobody had asked for more than 30 s"


def test_the_last_nine_records_are_kept_oldest_first() -> None:
    module = running()
    say(module, "42 61 10 02 01 13")
    for number in range(1, 12):
        say(module, "42 61 11 02 01 14", number * 10.0)
    found = records(module, 200.0)
    assert [one.uptime_s for one in found] == [60 + 10 * number for number in range(3, 12)]
    module.restart(300.0)
    tick(module, 301.0)
    assert records(module, 301.0) == found


def test_what_is_no_valid_frame_is_not_answered_and_the_next_one_is() -> None:
    module = running()
    for wrong in ("42 61 31 01 00 33", "42 61 31 01 01 33", "42 61 99 01 00 9a", "42 61 24 02 09 2f", "42 42 61"):
        assert say(module, wrong) == ""
    assert say(module, "42 61 23 01 00 24") == "41 75 23 01 01 25"
