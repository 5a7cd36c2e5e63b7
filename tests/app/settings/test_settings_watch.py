"""The fingerprint of the settings, and the comparison of a profile with a module."""

from functools import partial
from itertools import product
from types import MappingProxyType

import pytest

from app.engine.device import DeviceView, How, Known, StaleReason
from app.engine.identity import Identity, IdentityEvidence, Trust
from app.engine.setting_changes import READABLE_SETTINGS
from app.engine.snapshots import fresh_settings, snapshot_of
from app.procedures.read import read_everything
from app.procedures.write_all import SettingChange, WriteContext, write_all
from app.settings.fingerprint import ALPHABET, fingerprint, is_fingerprint
from app.settings.form import FormRow, Match, RowState, SettingsForm, compare
from app.settings.identity_words import identity_question
from app.settings.profiles import Profile
from protocol.catalogue import BY_NAME, SETTINGS
from protocol.fields import Value
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_frame
from tests.support.line.sim_line import Rig, settled_rig, watched

USUAL: dict[str, Value] = {
    "light_threshold_v": 1.8,
    "attitude_threshold_deg": 60,
    "freefall_acceleration_g": 0.5,
    "freefall_time_s": 1.6,
}


def code(**changed: Value) -> str:
    found = fingerprint({**USUAL, **changed}).code
    assert found is not None
    return found


def test_the_code_never_changes_between_versions() -> None:
    assert code() == "JFKY-2WSC"  # printed on stickers: never changes


def test_only_the_covered_settings_decide_the_code() -> None:
    assert code() == code(freefall_time_s=1.60, attitude_threshold_deg=60.0)
    assert code() == code(attitude_trigger=True, serial_output=False, baud_rate=9600)
    assert {command.name for command in set(SETTINGS) - set(READABLE_SETTINGS)} == {
        "serial_output", "attitude_trigger", "freefall_trigger", "baud_rate",
    }  # fmt: skip


def test_every_setting_changes_the_code() -> None:
    codes = {code()}
    for command in READABLE_SETTINGS:
        assert command.write is not None
        for raw in range(256):
            codes.add(code(**{command.key: command.write.decode(raw)}))
    assert len(codes) == 1 + 4 * 255


def test_missing_settings_are_reported_and_change_the_code() -> None:
    partly = {key: value for key, value in USUAL.items() if key != "freefall_time_s"}
    found = fingerprint(partly)
    assert [command.key for command in found.missing] == ["freefall_time_s"]
    assert not found.is_complete
    assert found.code != code()
    assert fingerprint({}).code is None


@pytest.mark.promise("f")
def test_the_check_finds_every_single_error() -> None:
    spoken = code()
    plain = spoken.replace("-", "")
    assert is_fingerprint(spoken)
    assert is_fingerprint(f" {spoken.lower()} ")
    for place, wrong in product(range(8), ALPHABET):
        damaged = plain[:place] + wrong + plain[place + 1 :]
        assert is_fingerprint(damaged) is (damaged == plain)
    for text in ("", plain[:-1], plain + "A", plain.replace(plain[0], "0"), "🪂" * 8):
        assert not is_fingerprint(text)


def test_the_code_of_a_module_and_its_profile() -> None:
    rig = Rig()
    rig.run(read_everything())
    device, now = rig.session.device.view(rig.clock()), rig.clock()
    assert fresh_settings(device, now) == {**USUAL, "baud_rate": 115200}
    assert fingerprint(fresh_settings(device, now)) == fingerprint(USUAL)


@pytest.mark.parametrize(
    ("known", "match", "is_ticked"),
    [
        (Known(1.6, How.READ, 1.0), Match.SAME, False),
        (Known(1.2, How.READ, 1.0), Match.DIFFERENT, True),
        (Known(1.6, How.READ, 1.0, StaleReason.RESTARTED), Match.UNKNOWN, True),
        (None, Match.UNKNOWN, True),
    ],
)
def test_rows_of_the_comparison(known: Known | None, match: Match, is_ticked: bool) -> None:
    values = {} if known is None else {"freefall_time_s": known}
    rows = compare(Profile(name="p", settings={"freefall_time_s": 1.6}), DeviceView(MappingProxyType(values)), 2.0)
    assert len(rows) == 8
    for row in rows:
        if row.command.key == "freefall_time_s":
            assert (row.target, row.module_value, row.match, row.is_worth_applying) == (1.6, known, match, is_ticked)
        else:
            assert (row.match, row.is_worth_applying) == (Match.NOT_IN_PROFILE, False)


# Verified settings are read again while connected, and changes without a write are reported.


KEY = "freefall_time_s"
WRITTEN = SettingChange(BY_NAME["freefall_time"], 1.2)


def rows(form: SettingsForm, rig: Rig) -> dict[str, FormRow]:
    now = rig.clock.now_s
    return {row.command.key: row for row in form.rows(rig.session.device.view(now), now)}


def states(form: SettingsForm, rig: Rig) -> dict[str, RowState]:
    return {key: row.state for key, row in rows(form, rig).items()}


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
        row = rows(form, rig)[KEY]
        assert row.state is RowState.VERIFIED
        assert row.module_value is not None
        assert rig.clock.now_s - row.module_value.at < 10.5


@pytest.mark.promise("f")
def test_a_later_change_takes_verified_away_and_says_so() -> None:
    rig, form = verified_rig()
    rig.bench.module.memory.freefall_time = 20
    rig.step_for(11.0)
    row = rows(form, rig)[KEY]
    assert row.state is RowState.CHANGED
    assert row.reason == "Was 1.20 s, now 0.20 s; not written here."
    rig.bench.module.memory.freefall_time = 120
    rig.step_for(11.0)
    assert states(form, rig)[KEY] is RowState.READ, "as it was written"


def test_an_unwritten_change_is_reported_until_it_is_accepted() -> None:
    rig, form = verified_rig()
    rig.bench.module.memory.attitude_threshold = 200
    rig.step_for(11.0)
    assert states(form, rig)["attitude_threshold_deg"] is RowState.CHANGED
    assert states(form, rig)[KEY] is RowState.VERIFIED
    form.watch.accept()
    assert states(form, rig)["attitude_threshold_deg"] is RowState.READ


def test_a_single_differing_reading_is_repeated_at_once() -> None:
    rig, form = verified_rig()
    for number, raw in enumerate((77, 120), start=1):
        change = partial(setattr, rig.bench.module.memory, "freefall_time", raw)
        at_frame(rig.bench, number, change, code=0x22)
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


# What is kept as the module's settings.


NOW_S = 100.0


@pytest.mark.promise("f")
def test_the_serial_output_which_the_program_switches_is_in_no_profile_and_no_snapshot() -> None:
    known = {command.key: Known(True, How.ACKNOWLEDGED, NOW_S) for command in SETTINGS}
    device = DeviceView(values={**known, "boot_count": Known(37, How.READ, NOW_S)})
    others = {command.key for command in SETTINGS} - {"serial_output"}
    snapshot = snapshot_of(device, NOW_S)
    assert (snapshot.settings.keys(), snapshot.boot_count) == (others, 37)


@pytest.mark.parametrize(
    ("now", "is_adapter_same", "name", "asked"),
    [
        (IdentityEvidence(36, USUAL), False, "M-07", "This may be another module: boot count 36, was 37."),
        (IdentityEvidence(), False, "M-07", "This may be another module: the port leads to another device."),
        (IdentityEvidence(), True, "M-07", "M-07? Read its label."),
        (IdentityEvidence(), True, "", "This may be another module: link lost."),
    ],
)
def test_what_is_asked_names_the_strongest_reason(
    now: IdentityEvidence, is_adapter_same: bool, name: str, asked: str
) -> None:
    before = IdentityEvidence(37, USUAL)
    assert identity_question(Identity(Trust.OPEN, before, now, is_adapter_same=is_adapter_same), name) == asked
