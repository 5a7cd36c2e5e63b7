"""What is known of a module from before: without it the check says so, and damage in it never costs the verdict."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from app.preflight.checks import Person
from app.records.filing import file_check
from app.records.report import report_html
from app.settings.profiles import NO_PROFILE
from app.store.fact_store import FILE_NAME
from app.system.files import data_folder
from tests.support.cli_line import Program
from tests.support.line.sim_line import settled_rig
from tests.support.records.preflight_rig import gather
from tests.support.records.stored import tamper

pytest_plugins = ["tests.support.cli_fixtures"]
WORDS = ("--enable-triggers", "--module", "M-07", "--who", "Li Wei", "--aircraft", "B-1234")


@pytest.fixture(autouse=True)
def _hurried(speaks_english: None, no_waiting: None) -> None:
    """In English, and without waiting for the clock."""


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


def test_without_a_name_a_module_or_an_aircraft_it_is_unsigned() -> None:
    evidence = replace(gather(settled_rig(), is_enabling=True), port="/dev/ttyUSB0")
    for person, said in (
        (Person(), ["UNSIGNED, missing: Checked by, Module, Aircraft."]),
        (Person(who="Li Wei", module="M-07", aircraft=" "), ["UNSIGNED, missing: Aircraft."]),
        (Person(who=" Li Wei", module="M-07", aircraft="B-1234 "), []),
    ):
        filed = file_check(evidence, NO_PROFILE, person, store=None)
        assert [caveat.in_english() for caveat in filed.record.caveats] == said
        assert all(one in report_html(filed.exported) for one in said)
