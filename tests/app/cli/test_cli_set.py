"""`dps-s set`: every setting, the profile, what is refused before anything is sent, and what is claimed afterwards."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import app.__main__ as program
from app.engine import transport
from app.preflight.reading_object import SETTING_KEYS
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.settings.profile_file import read_profile, save_profile
from app.settings.profiles import Profile
from app.store.database import FILE_NAME
from app.store.facts import FactKind
from app.store.store import open_store
from app.system.folders import data_folder
from app.terminal.interruption import Interrupted, Interruption
from protocol.catalogue import BY_NAME, SETTINGS
from tests.support.cli_line import Printed, Program, bench_of
from tests.support.records.kept_facts import kept_settings

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")

ALL = {
    "attitude_threshold_deg": 65,
    "freefall_acceleration_g": 0.4,
    "freefall_time_s": 1.2,
    "light_threshold_v": 2.1,
    "attitude_trigger": False,
    "freefall_trigger": True,
    "serial_output": False,
    "baud_rate": 57600,
}


def words_of(values: dict[str, Any]) -> list[str]:
    return [f"{name}={str(value).lower()}" for name, value in values.items()]


def sets(wire: list[bytes]) -> list[bytes]:
    return [frame for frame in wire if frame[3] == 0x02]


def test_the_names_are_the_catalogues(capsys: pytest.CaptureFixture[str]) -> None:
    assert {command.key for command in SETTINGS} == set(ALL)
    program.main(["set", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert ", ".join(SETTING_KEYS) in said


@pytest.mark.parametrize("options", ["", "?ack=one&freefall_ack=17&baud_ack=new"])
def test_every_setting_at_once(options: str, port: str, dps_s: Program, wire: list[bytes]) -> None:
    before = json.loads(dps_s(["read", "--port", port + options, "--json"]).out)["settings"]
    wire.clear()
    printed = dps_s(["set", *words_of(ALL), "--accept-risk", "--port", port + options, "--json"])
    results = json.loads(printed.out)["results"]
    assert list(results) == list(ALL)
    flags = ("attitude_trigger", "freefall_trigger", "serial_output")
    for name, value in ALL.items():
        is_flag = name in flags
        is_acknowledged = not (name == "baud_rate" and options)
        age_s = results[name].pop("verified_age_s")
        assert (age_s is None) if is_flag else (0.0 < age_s < 5.0)
        assert results[name] == {
            "wanted": value,
            "before": None if is_flag else before[name],
            "acknowledged": is_acknowledged,
            "read_back": None if is_flag else value,
            "verified": None if is_flag else True,
            "error": None,
        }
    assert len(sets(wire)) == len(ALL)
    module = bench_of(port).module
    assert (module.memory.attitude_threshold, module.memory.freefall_time, module.baud_rate) == (65, 120, 57600)
    assert (module.state.attitude_is_enabled, module.state.freefall_is_enabled) == (False, True)
    assert "baud_rate: Vendor advises: Do not change it." in printed.err


def test_a_profile_that_takes_protection_away_needs_accept_risk(
    port: str, dps_s: Program, wire: list[bytes], tmp_path: Path
) -> None:
    path = tmp_path / "a b.toml"
    save_profile(path, Profile(name="Show", settings={"attitude_trigger": False, "light_threshold_v": 2.0}))
    words = ["set", "--profile", str(path), "--port", port, "--json"]
    printed = dps_s(words, 2)
    assert (printed.out, wire) == ("", [])
    assert printed.err.splitlines() == [
        "Warning: attitude_trigger: No protection when it tips over.", "Nothing was done. Add --accept-risk to do it.",
    ]  # fmt: skip
    assert 'error": null' in dps_s([*words, "--accept-risk"]).out
    assert len(sets(wire)) == 2


def test_an_endless_number_is_refused_in_a_sentence(port: str, dps_s: Program) -> None:
    printed = dps_s(["set", "attitude_threshold_deg=9" + "9" * 5000, "--port", port, "--json"], 2)
    assert "a number is needed" in printed.err
    assert len(printed.err) < 400


def test_a_profile_is_written_and_proven(tmp_path: Path, port: str, dps_s: Program, wire: list[bytes]) -> None:
    path = tmp_path / "H6.toml"
    save_profile(path, Profile(name="H6", settings={**ALL, "baud_rate": 115200}))
    results = json.loads(dps_s(["set", "--profile", str(path), "--accept-risk", "--port", port, "--json"]).out)[
        "results"
    ]
    assert set(results) == set(ALL)
    assert {name for name, result in results.items() if result["verified"]} == {
        "attitude_threshold_deg", "freefall_acceleration_g", "freefall_time_s", "light_threshold_v", "baud_rate",
    }  # fmt: skip
    assert results["baud_rate"]["acknowledged"] is None
    assert BY_NAME["baud_rate"].code not in {frame[2] for frame in wire}


def test_all_errors_of_a_profile_are_said_and_nothing_is_sent(
    tmp_path: Path, port: str, capsys: pytest.CaptureFixture[str], wire: list[bytes]
) -> None:
    path = tmp_path / "H6.toml"
    path.write_text("[settings]\nfreefall_acceleration_g = 0.55\nfreefall_tme_s = 1.6\n", encoding="utf-8")
    assert program.main(["set", "--profile", str(path), "--port", port]) == 2
    assert [line.partition(":")[0] for line in Printed(capsys).err.splitlines()] == ["Line 2", "Line 3"]
    assert wire == []
    path.write_text('name = "empty"\n', encoding="utf-8")
    assert program.main(["set", "--profile", str(path), "--port", port]) == 2


def test_it_is_recorded_and_the_old_values_are_kept(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert program.main(["set", "freefall_time_s=1.2", "--port", port]) == 0
    store = open_store()
    try:
        (entry,) = store.audit()
        assert (entry.act, entry.outcome, entry.port) == (Act.WRITE, Outcome.CONFIRMED, port)
        assert store.facts.select(FactKind.ACT)[0].content["origin"] == "command line"
        assert entry.frame == BY_NAME["freefall_time"].set(1.2).encode()
        assert entry.result["read_back"] == 1.2
        (kept,) = kept_settings(store)
        assert kept["freefall_time_s"] == 1.6
    finally:
        store.close()


def test_without_a_store_settings_are_written_and_the_rate_is_not(port: str, dps_s: Program, wire: list[bytes]) -> None:
    data_folder().parent.mkdir(parents=True)
    data_folder().write_text("in the way", encoding="utf-8")
    printed = dps_s(["set", "freefall_time_s=1.2", "baud_rate=9600", "--port", port, "--json"], 1)
    results = json.loads(printed.out)["results"]
    assert results["freefall_time_s"]["verified"] is True
    assert results["baud_rate"]["error"].startswith("not sent: The audit log cannot be written")
    assert f"The program may not write into {data_folder() / FILE_NAME}." in printed.err
    assert len(sets(wire)) == 1


def after_set(monkeypatch: pytest.MonkeyPatch, code: int, act: Callable[[], None]) -> None:
    """`act` happens right after a set of this code went onto the wire."""
    write = transport.SerialLine.write

    def written(line: transport.SerialLine, data: bytes) -> None:
        write(line, data)
        if data[2:4] == bytes((code, 0x02)):
            act()

    monkeypatch.setattr(transport.SerialLine, "write", written)


def test_a_setting_that_nobody_wrote_and_that_changed_is_named(
    port: str, dps_s: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    memory = bench_of(port).module.memory
    after_set(monkeypatch, 0x22, lambda: setattr(memory, "freefall_acceleration", 20))
    printed = dps_s(["set", "freefall_time_s=1.2", "--port", port, "--json"], 1)
    told = json.loads(printed.out)
    assert told["results"]["freefall_time_s"]["verified"] is True
    assert told["changed"] == {"freefall_acceleration_g": {"before": 0.5, "after": 2.0}}
    assert "Changed without being written: freefall_acceleration_g 0.5 → 2." in printed.err


def test_unplugged_in_the_middle_says_what_stands_and_what_is_not_known(
    port: str, dps_s: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    after_set(monkeypatch, 0x15, bench_of(port).unplug)
    words = ["freefall_time_s=1.2", "light_threshold_v=2", "attitude_threshold_deg=65"]
    printed = dps_s(["set", *words, "--port", port, "--json"], 3)
    results = json.loads(printed.out)["results"]
    assert results["freefall_time_s"]["verified"] is False
    assert results["freefall_time_s"]["error"] == "not read again"
    assert results["light_threshold_v"]["error"] == "port lost; may have been carried out"
    assert results["attitude_threshold_deg"]["error"] == "not sent: the port was lost"
    assert "unplugged" in printed.err


@pytest.mark.parametrize("is_json", [False, True])
def test_interrupted_it_says_what_became_of_each(
    is_json: bool, port: str, dps_s: Program, wire: list[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    def check(_interruption: Interruption) -> None:
        if len(sets(wire)) == 2:
            raise Interrupted(2)

    monkeypatch.setattr(Interruption, "check", check)
    after_set(monkeypatch, 0x22, lambda: bench_of(port).change(mute=True))  # however late it is interrupted
    words = words_of({name: ALL[name] for name in ("baud_rate", "attitude_threshold_deg", "freefall_time_s")})
    printed = dps_s(["set", *words, "--port", port, *(["--json"] if is_json else [])], 130)
    first, second, third = (line for line in printed.err.splitlines() if not line.startswith("Warning"))
    assert printed.out == ""
    assert first == "attitude_threshold_deg  65: NOT verified (not read again)"
    assert second.split(maxsplit=1) == ["freefall_time_s", "Interrupted; may have been carried out."]
    assert third.split(maxsplit=1) == ["baud_rate", "not sent: interrupted"]


# Settings as a file: saved, compared, shown before they are written.


def test_what_is_saved_says_its_origin_and_can_be_written_again(
    port: str, tmp_path: Path, dps_s: Program, wire: list[bytes]
) -> None:
    path = tmp_path / "M-07.toml"
    dps_s(["save", "-p", port, str(path), "--module", "M-07"])
    assert not [frame for frame in wire if frame[3] == 0x02]
    text = path.read_text(encoding="utf-8")
    shown = json.loads(dps_s(["read", "-p", port, "--json"]).out)
    for line in (f"# Port: {port}, 115200 baud", f"# Boot count: {shown['boot_count']}", "# SIMULATED MODULE",
                 "# Settings code: ", "# attitude_trigger: cannot be read"):  # fmt: skip
        assert line in text
    profile = read_profile(path)
    assert profile.name == "M-07"
    assert profile.settings == {key: value for key, value in shown["settings"].items() if value is not None}
    assert "unchanged" in dps_s(["set", "--profile", str(path), "-p", port, "--dry-run"]).out
    assert dps_s(["save", "-p", port, "-"]).out.endswith(text[text.index("[settings]") :])
