"""All settings in one reading, on one start of the module, and what differs between two readings."""

from typing import Any

from app.engine.setting_changes import changed_settings
from app.procedures.settings_reading import ReadFault, SettingsReading, read_settings
from protocol.catalogue import BY_NAME, Hazard
from tests.support.line.sim_line import Rig

ALL = {"light_threshold_v": 1.8, "attitude_threshold_deg": 60, "freefall_acceleration_g": 0.5, "freefall_time_s": 1.6}


def read(rig: Rig) -> SettingsReading:
    return rig.run(read_settings())


def at_question(rig: Rig, code: int, number: int, act: Any) -> None:
    """Call `act` when the question with this code arrives for the `number`th time."""
    line_write, seen = rig.line.write, 0

    def watched(data: bytes) -> None:
        nonlocal seen
        seen += data[2] == code
        if data[2] == code and seen == number:
            act()
        line_write(data)

    rig.line.write = watched  # type: ignore[method-assign]


def test_all_settings_and_the_boot_count_are_read_by_questions_only() -> None:
    rig = Rig()
    reading = read(rig)
    assert reading.values == ALL
    assert reading.boot_count == rig.bench.module.memory.boot_count
    assert reading.is_complete
    assert {request.hazard for request in rig.line.requests} == {Hazard.NONE}
    codes = [request.command.code for request in rig.line.requests]
    assert codes[:2] == codes[-2:] == [0x23, 0x23]
    assert all(codes.count(BY_NAME[key].code) == 2 for key in ("freefall_time", "attitude_threshold"))


def test_a_restart_in_the_middle_leaves_no_boot_count() -> None:
    rig = Rig()
    at_question(rig, 0x20, 1, rig.bench.restart)
    reading = read(rig)
    assert (reading.is_restarted, reading.boot_count, reading.is_complete) == (True, None, False)


def test_a_restart_that_nobody_heard_is_seen_in_the_boot_count() -> None:
    rig = Rig()

    def restart_unheard() -> None:
        rig.bench.module.memory.boot_count += 1

    at_question(rig, 0x21, 1, restart_unheard)
    reading = read(rig)
    assert (reading.is_restarted, reading.boot_count) == (True, None)


def test_an_unanswered_setting_is_named_and_the_others_are_read() -> None:
    reading = read(Rig({"mute_codes": frozenset((0x22,))}))
    assert reading.faults == {"freefall_time_s": ReadFault.NO_REPLY}
    assert reading.values == {key: value for key, value in ALL.items() if key != "freefall_time_s"}
    assert not reading.is_complete
    assert not reading.is_silent


def test_a_module_that_falls_silent_is_asked_no_further() -> None:
    rig = Rig()
    at_question(rig, 0x20, 1, lambda: rig.bench.change(mute=True))
    reading = read(rig)
    assert reading.is_silent
    assert not reading.is_complete
    assert [request.command.code for request in rig.line.requests].count(0x21) == 0


def test_what_changed_between_two_readings_is_named() -> None:
    rig = Rig()
    first = read(rig)
    assert changed_settings(first.values, read(rig).values) == ()
    rig.bench.module.memory.attitude_threshold = 200
    rig.bench.module.memory.freefall_time = 20
    changed = changed_settings(first.values, read(rig).values)
    assert [(one.command.key, one.before, one.after) for one in changed] == [
        ("attitude_threshold_deg", 60, 200),
        ("freefall_time_s", 1.6, 0.2),
    ]
    assert changed_settings({}, first.values) == ()
