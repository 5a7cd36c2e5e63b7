"""`dps-s set`: every setting, the profile, what is refused before anything is sent, and what is claimed afterwards."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

import app.__main__ as program
from app.engine import transport
from app.safety.journal import Act, Outcome
from app.settings.profiles import Profile, save_profile
from app.store.fact_store import FILE_NAME
from app.system.files import data_folder
from app.terminal.console import Signalled
from protocol.catalogue import BY_NAME
from tests.support.cli_line import Program, bench_of
from tests.support.records.stored import audit, kept_settings, open_store

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")


def sets(wire: list[bytes]) -> list[bytes]:
    return [frame for frame in wire if frame[3] == 0x02]


@pytest.mark.promise("g")
def test_a_profile_that_takes_protection_away_needs_accept_risk(
    port: str, dps_s: Program, wire: list[bytes], tmp_path: Path
) -> None:
    path = tmp_path / "a b.toml"
    save_profile(path, Profile(name="Show", settings={"attitude_trigger": False, "light_threshold_v": 2.0}))
    words = ["set", "--profile", str(path), "--port", port, "--json"]
    printed = dps_s(words, 2)
    assert (json.loads(printed.out)["error"]["code"], wire) == ("usage", [])
    assert printed.err.splitlines() == [
        "Warning: attitude_trigger: No protection when it tips over.", "Nothing was done. Add --accept-risk to do it.",
    ]  # fmt: skip
    assert 'error": null' in dps_s([*words, "--accept-risk"]).out
    assert len(sets(wire)) == 2


def test_where_a_profile_is_wrong_nothing_is_sent(tmp_path: Path, port: str, dps_s: Program, wire: list[bytes]) -> None:
    path = tmp_path / "H6.toml"
    path.write_text("[settings]\nfreefall_acceleration_g = 0.55\nfreefall_tme_s = 1.6\n", encoding="utf-8")
    printed = dps_s(["set", "--profile", str(path), "--port", port], 2)
    assert printed.err.startswith("settings.freefall_acceleration_g: expected 0.0 g to 25.5 g, in steps of 0.1 g.\n")
    assert wire == []
    path.write_text('name = "empty"\n', encoding="utf-8")
    assert program.main(["set", "--profile", str(path), "--port", port]) == 2


def test_it_is_recorded_and_the_old_values_are_kept(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert program.main(["set", "freefall_time_s=1.2", "--port", port]) == 0
    store = open_store()
    try:
        (entry,) = audit(store)
        assert (entry.act, entry.outcome, entry.port) == (Act.WRITE, Outcome.CONFIRMED, port)
        assert entry.origin == "command line"
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


@pytest.mark.promise("f")
def test_a_setting_that_nobody_wrote_and_that_changed_is_named(
    port: str, dps_s: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    memory = bench_of(port).module.memory
    after_set(monkeypatch, 0x22, lambda: setattr(memory, "freefall_acceleration", 20))
    printed = dps_s(["set", "freefall_time_s=1.2", "--port", port, "--json"], 1)
    told = json.loads(printed.out)
    written = told["results"]["freefall_time_s"]
    assert (written["verified"], written["error"]) == (False, "verified then, before the interruption")
    assert "Changed without being written: freefall_acceleration_g 0.5 → 2." in printed.err


@pytest.mark.parametrize("is_json", [False, True])
def test_interrupted_it_says_that_it_may_have_been_carried_out(
    is_json: bool, port: str, dps_s: Program, wire: list[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    def check() -> None:
        if len(sets(wire)) == 2:
            raise Signalled(2)

    monkeypatch.setattr("app.terminal.connection.check_signals", check)
    words = ["attitude_threshold_deg=65", "freefall_time_s=1.2", "light_threshold_v=2"]
    printed = dps_s(["set", *words, "--port", port, *(["--json"] if is_json else [])], 130)
    assert printed.out == "" or json.loads(printed.out)["error"]["code"] == "cancelled"
    assert printed.err.startswith("Interrupted; may have been carried out.\n")
    assert len(sets(wire)) == 2
