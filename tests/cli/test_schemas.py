"""Every --json, and the record of a check, is as its published schema says."""

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

import app.__main__ as program
from app.cli.commands import ENTRIES
from app.cli.schema import SCHEMAS as NAMES
from app.cli.schema import schema_of
from app.store.rows import PreflightCheck
from tests.support.cli_line import Printed, Program, run_here
from tests.support.records.stored import open_store

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "user_files", "hasty", "no_waiting")


def faults(name: str, value: object) -> list[str]:
    from jsonschema import Draft202012Validator  # 4 MB, only where it is used

    if isinstance(value, dict) and value.keys() == {"error"}:
        name = "error"
    validator = Draft202012Validator(schema_of(name), format_checker=Draft202012Validator.FORMAT_CHECKER)
    return [f"{error.json_path}: {error.message}" for error in validator.iter_errors(value)]


def lines(capsys: pytest.CaptureFixture[str]) -> list[Any]:
    return [json.loads(line) for line in Printed(capsys).out.splitlines()]


@pytest.mark.parametrize("name", NAMES)
def test_the_command_prints_a_valid_schema(name: str, dps_s: Program) -> None:
    from jsonschema import Draft202012Validator

    printed = json.loads(dps_s(["schema", name]).out)
    Draft202012Validator.check_schema(printed)
    assert printed == schema_of(name)


@pytest.mark.parametrize("name", ["monitor", "ports", "recordings"])
def test_what_varies_is_as_its_schema_says(
    name: str, port: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = {"monitor": ["--port", port, "--seconds", "0.2"], "recordings": ["list"]}.get(name, [])
    if name == "recordings":
        run_here(capsys, ["record", "--port", port, "--seconds", "0.1", str(tmp_path / "a.csv")])
    assert program.main([name, *words, "--json"]) == 0
    found = lines(capsys)
    assert found
    assert [fault for one in found for fault in faults(name, one)] == []


def test_the_record_of_a_check_is_as_its_schema_says(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["preflight", "--port", f"{port}?history=2", "--enable-triggers", "--module", "M-07", "--json"]
    for _ in range(2):
        assert program.main(words) == 1
    store = open_store()
    kept = store.read(lambda facts: facts.of_kind(PreflightCheck))
    records = [json.loads(check.content.document) for check in kept]
    store.close()
    assert len(records) == 2
    assert [fault for record in records for fault in faults("record", record)] == []
    Printed(capsys)


# Completion scripts know every command and option; the one for bash is run by bash.


_ASK = """
source "$1"; shift
COMP_WORDS=(dps-s "$@"); COMP_CWORD=$(($#))
_shtab_dps_s 2>/dev/null
printf '%s\\n' "${COMPREPLY[@]}"
"""


def printed(shell: str, capsys: pytest.CaptureFixture[str]) -> str:
    return run_here(capsys, ["completion", shell]).out


def test_the_script_for_zsh_knows_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    script = printed("zsh", capsys)
    assert [entry.name for entry in ENTRIES if entry.name not in script] == []


@pytest.mark.skipif(os.name == "nt", reason="bash is no shell of Windows")
def test_bash_completes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bash = shutil.which("bash")
    assert bash is not None
    script = tmp_path / "dps-s"
    script.write_text(printed("bash", capsys).replace("/dev/ttyUSB*", str(tmp_path / "tty*")), encoding="utf-8")
    (tmp_path / "my profile.toml").touch()
    (tmp_path / "ttyUSB0").touch()

    def completed(*words: str) -> list[str]:
        done = subprocess.run(
            [bash, "--norc", "-c", _ASK, "bash", str(script), *words],
            cwd=tmp_path, text=True, capture_output=True, timeout=60, check=True,
        )  # fmt: skip
        assert done.stderr == ""
        return [line for line in done.stdout.splitlines() if line]

    assert sorted(completed("")) == sorted(entry.name for entry in ENTRIES)
    assert completed("recordings", "ex") == ["export"]
    assert completed("read", "--j") == ["--json"]
    assert completed("read", "--port", str(tmp_path / "ttyU"))[0] == str(tmp_path / "ttyUSB0")
    assert completed("set", "--profile", "my") == ["my profile.toml"]
    assert completed("decode", "--asked", "cell") == ["cell_voltage"]
