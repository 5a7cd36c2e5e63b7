"""The fingerprint of the settings, and the comparison of a profile with a module."""

from itertools import product
from types import MappingProxyType

import pytest

from app.engine.device import DeviceView, How, Known, StaleReason
from app.procedures.read import read_everything
from app.settings.fingerprint import ALPHABET, COVERED, fingerprint, fingerprint_of, is_fingerprint
from app.settings.profiles import Match, Profile, compare, profile_of
from protocol.catalogue import SETTINGS
from protocol.fields import Value
from tests.support.line.sim_line import Rig

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
    assert {command.name for command in set(SETTINGS) - set(COVERED)} == {
        "serial_output", "attitude_trigger", "freefall_trigger", "baud_rate",
    }  # fmt: skip


def test_every_setting_changes_the_code() -> None:
    codes = {code()}
    for command in COVERED:
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
    assert fingerprint_of(device, now) == fingerprint(USUAL)
    saved = profile_of(device, now, name="as it is")
    assert saved.settings == {**USUAL, "baud_rate": 115200}
    assert fingerprint(saved.settings) == fingerprint(USUAL)


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
            assert (row.wanted, row.stands, row.match, row.is_worth_applying) == (1.6, known, match, is_ticked)
        else:
            assert (row.match, row.is_worth_applying) == (Match.NOT_IN_PROFILE, False)
