"""What is known of a module from before: without it the check says so, and damage in it never costs the verdict."""

import json
import shutil
import sqlite3
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest

from app.preflight.findings import Person
from app.preflight.verdict import Verdict, blocks_go
from app.records.filing import file_check
from app.records.report import report_html
from app.settings.profile_file import parse_profile
from app.settings.profiles import NO_PROFILE, Profile
from app.store.opening import FILE_NAME, copies_of, copy_if_due
from app.store.trouble import StoreFault, trouble_of
from app.system.folders import data_folder
from tests.support.cli_line import Printed, Program, bench_of
from tests.support.line.sim_line import Rig, settled_rig
from tests.support.records.kept_facts import tamper
from tests.support.records.preflight_rig import gather

pytest_plugins = ["tests.support.cli_fixtures"]
WORDS = ("--enable-triggers", "--module", "M-07", "--who", "Li Wei", "--aircraft", "B-1234")


@pytest.fixture(autouse=True)
def _hurried(speaks_english: None, no_waiting: None) -> None:
    """In English, and without waiting for the clock."""


def _boot_count(printed: Printed) -> tuple[str, str, str]:
    """Verdict, result and what was found of the boot count; then what was said beside it."""
    shown = json.loads(printed.out)
    one = next(one for one in shown["checks"] if one["id"] == "boot_count")
    return shown["verdict"], one["result"], one["why"]


def _refused(printed: Printed) -> bool:
    """Because the boot count speaks against its being the module of that name."""
    error = json.loads(printed.out)["error"]
    return error["code"] == "refused" and "boot count 12, was 37" in error["message"]


@pytest.mark.promise("f")
def test_no_memory_of_a_module_is_said_and_is_a_warning(port: str, dps_s: Program) -> None:
    words = ["preflight", "--port", port, "--json", *WORDS]
    verdict, result, why = _boot_count(dps_s(words))
    assert (verdict, result) == ("READY", "warn")
    assert "no earlier visit" in why
    assert _boot_count(dps_s(words))[:2] == ("READY", "pass")
    bench_of(port).module.memory.boot_count = 12
    assert _refused(dps_s(words, 1))
    _copy_now()
    (data_folder() / FILE_NAME).unlink()
    for companion in ("-wal", "-shm"):
        (data_folder() / f"{FILE_NAME}{companion}").unlink(missing_ok=True)
    (data_folder() / FILE_NAME).write_bytes(b"")
    assert _refused(dps_s(words, 1)), "restored from its copy: the module is still known"
    shutil.rmtree(data_folder())
    _verdict, result, why = _boot_count(dps_s(words))
    assert result == "warn"
    assert "no earlier visit" in why


def _copy_now() -> None:
    """In place of the day's first copy, which is made while the store is still empty."""
    path, now = data_folder() / FILE_NAME, datetime.now(UTC)
    for copy in copies_of(path, now):
        copy.unlink()
    copy_if_due(path, now)


def _damaged(kind: str, key: str, value: str) -> str:
    return f"UPDATE facts SET content = json_set(content, '$.{key}', {value}) WHERE kind = '{kind}'"


DAMAGES = (
    _damaged("visit", "slots", "'no list'"), _damaged("visit", "slots", "json('[1, 2]')"),
    _damaged("visit", "slots", "json('[\"zz\"]')"), _damaged("visit", "boot_count", "10000000"),
    _damaged("preflight_check", "verdict", "3"), _damaged("preflight_check", "document", "'{'"),
    _damaged("preflight_check", "cell_voltage_v", "'x'"), _damaged("trigger_record", "raw", "'zz'"),
    "UPDATE facts SET content = '{'", "UPDATE facts SET content = '[]'", "UPDATE state SET value = '{'",
    "DROP TABLE facts", "DROP TABLE state",
)  # fmt: skip


@pytest.mark.promise("f")
def test_damage_in_the_store_never_costs_the_verdict(port: str, dps_s: Program, tmp_path: Path) -> None:
    words = ["preflight", "--port", f"{port}?history=2", "--json", "--records-reviewed", *WORDS]
    dps_s(words)
    data_folder().rename(tmp_path / "sound")
    for damage in DAMAGES:
        shutil.copytree(tmp_path / "sound", data_folder(), dirs_exist_ok=True)
        tamper(data_folder() / FILE_NAME, damage)
        printed = dps_s([*words, "--same-module"])
        assert json.loads(printed.out)["verdict"] == "READY", (damage, printed.out)
        assert "Traceback" not in printed.err, damage


def test_a_full_disk_is_called_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    error = sqlite3.OperationalError("unable to open database file")
    monkeypatch.setattr(error, "sqlite_errorname", "SQLITE_CANTOPEN", raising=False)
    assert trouble_of(error, tmp_path / FILE_NAME).fault is StoreFault.READ_ONLY
    monkeypatch.setattr("app.store.trouble._is_full", lambda path: True)
    assert trouble_of(error, tmp_path / FILE_NAME).fault is StoreFault.FULL


# Who, and what a person looked at


def _filed(rig: Rig, person: Person, expectations: Profile | None = None) -> tuple[Verdict, list[str], str]:
    evidence = replace(gather(rig, is_enabling=True), port="/dev/ttyUSB0")
    filed = file_check(evidence, expectations or NO_PROFILE, person, store=None)
    caveats = [caveat.in_english() for caveat in filed.record.caveats]
    return filed.assessment.verdict, caveats, report_html(filed.exported)


def test_without_a_name_a_module_or_an_aircraft_it_is_unsigned() -> None:
    rig = settled_rig()
    verdict, beside, page = _filed(rig, Person())
    assert verdict is Verdict.READY
    assert beside == ["UNSIGNED, missing: Checked by, Module, Aircraft."]
    assert "UNSIGNED, missing: Checked by, Module, Aircraft." in page
    assert _filed(rig, Person(who="Li Wei", module="M-07", aircraft=" "))[1] == ["UNSIGNED, missing: Aircraft."]
    assert _filed(rig, Person(who=" Li Wei", module="M-07", aircraft="B-1234 "))[1] == []


def test_the_command_line_says_so_and_that_nothing_is_watched(port: str, dps_s: Program) -> None:
    out = dps_s(["preflight", "--port", port, "--enable-triggers"]).out
    assert "UNSIGNED, missing: Checked by, Module, Aircraft." in out
    assert "SIMULATED MODULE: no evidence." in out
    assert "not monitored afterwards" in out


def test_two_manual_items_with_one_text_are_two() -> None:
    item = '[[manual]]\ntext = "Look again"\nrequired = true\n'
    expectations = parse_profile((item * 2).encode()).answered({1: True})
    assert [one.is_done for one in expectations.manual] == [True, None]
    assert [blocks_go(one) for one in expectations.manual] == [False, True]
