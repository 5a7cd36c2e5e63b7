"""Verified settings are read again while connected, and changes without a write are reported."""

from app.procedures.write_all import SettingChange, WriteContext, write_all
from app.settings.form import RowState, SettingsForm
from protocol.catalogue import BY_NAME
from tests.support.journals import FakeJournal
from tests.support.line.sim_line import Rig, settled_rig, watched

KEY = "freefall_time_s"
WRITTEN = SettingChange(BY_NAME["freefall_time"], 1.2)


def states(form: SettingsForm, rig: Rig) -> dict[str, RowState]:
    now = rig.clock.now_s
    return {row.command.key: row.state for row in form.rows(rig.session.device.view(now), now)}


def verified_rig() -> tuple[Rig, SettingsForm]:
    rig, form = settled_rig(), SettingsForm()
    watched(rig)
    rig.step_for(4.0)
    states(form, rig)
    form.begin_write([WRITTEN])
    form.on_written(rig.run(write_all([WRITTEN], WriteContext(journal=FakeJournal()))).results)
    assert states(form, rig)[KEY] is RowState.VERIFIED
    return rig, form


def test_verified_is_read_again_every_ten_seconds() -> None:
    rig, form = verified_rig()
    for _ in range(30):
        rig.step_for(1.0)
        row = next(row for row in form.rows(rig.session.device.view(rig.clock.now_s), rig.clock.now_s)
                   if row.command.key == KEY)  # fmt: skip
        assert row.state is RowState.VERIFIED
        assert row.module_value is not None
        assert rig.clock.now_s - row.module_value.at < 10.5


def test_a_later_change_takes_verified_away_and_says_so() -> None:
    rig, form = verified_rig()
    rig.bench.module.memory.freefall_time = 20
    rig.step_for(11.0)
    row = next(row for row in form.rows(rig.session.device.view(rig.clock.now_s), rig.clock.now_s)
               if row.command.key == KEY)  # fmt: skip
    assert row.state is RowState.CHANGED
    assert row.reason == "Was 1.20 s, now 0.20 s; not written here."


def test_an_unwritten_change_is_reported_until_it_is_accepted() -> None:
    rig, form = verified_rig()
    rig.bench.module.memory.attitude_threshold = 200
    rig.step_for(11.0)
    assert states(form, rig)["attitude_threshold_deg"] is RowState.CHANGED
    assert states(form, rig)[KEY] is RowState.VERIFIED
    form.watch.accept()
    assert states(form, rig)["attitude_threshold_deg"] is RowState.READ


def test_a_side_effect_of_a_write_is_reported() -> None:
    rig, form = settled_rig(**{"cross-talk": "22:20=C8"}), SettingsForm()
    watched(rig)
    rig.step_for(4.0)
    states(form, rig)
    form.begin_write([WRITTEN])
    report = rig.run(write_all([WRITTEN], WriteContext(journal=FakeJournal())))
    assert [(one.command.key, one.before, one.after) for one in report.changed] == [("attitude_threshold_deg", 60, 200)]
    form.on_written(report.results)
    found = states(form, rig)
    assert (found[KEY], found["attitude_threshold_deg"]) == (RowState.VERIFIED, RowState.CHANGED)


def test_a_single_differing_reading_is_repeated_at_once() -> None:
    rig, form = verified_rig()
    memory, line_write, answers = rig.bench.module.memory, rig.line.write, [77, 120]

    def wrong_once(data: bytes) -> None:
        if data[2:4] == b"\x22\x01" and answers:
            memory.freefall_time = answers.pop(0)
        line_write(data)

    rig.line.write = wrong_once  # type: ignore[method-assign]
    rig.step_until(lambda: rig.session.device.view(0).values[KEY].value == 0.77, limit_s=12)
    rig.step_for(0.1)
    assert rig.session.device.view(0).values[KEY].value == 1.2
    assert states(form, rig)[KEY] is RowState.VERIFIED


def test_a_slow_line_delays_no_poll_too_long() -> None:
    rig = settled_rig(delay_ms=150, stream="silent")
    watched(rig)
    rig.step_for(60.0)
    values, now = rig.session.device.view(rig.clock.now_s).values, rig.clock.now_s
    assert now - values["tilt_deg"].at < 1.5
    assert now - values["cell_voltage_v"].at < 5.0
    assert now - values[KEY].at < 25.0
    assert now - values["boot_count"].at < 25.0
