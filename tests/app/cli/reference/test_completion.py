"""Completion scripts know every command, option and setting; the one for bash is run by bash."""

import argparse
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.cli.commands import ENTRIES, complete_parser
from app.preflight.reading_object import SETTING_KEYS
from tests.support.cli_line import run_here

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")

_ASK = """
source "$1"; shift
COMP_WORDS=(dps-s "$@"); COMP_CWORD=$(($#))
COMP_LINE="dps-s $*"; COMP_LINE=${COMP_LINE// = /=}; COMP_LINE=${COMP_LINE// =/=}; COMP_POINT=${#COMP_LINE}
_dps_s 2>/dev/null
printf '%s\\n' "${COMPREPLY[@]}"
"""


def printed(shell: str, capsys: pytest.CaptureFixture[str]) -> str:
    return run_here(capsys, ["completion", shell]).out


def parsers(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """The parser and those of all commands below it."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for one in action.choices.values():
                yield from parsers(one)


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_script_names_every_command_option_and_setting(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    script = printed(shell, capsys)
    for entry in ENTRIES:
        assert entry.name in script
    for parser in parsers(complete_parser()):
        assert {"--help", "--verbose", "--quiet"} <= parser._option_string_actions.keys() or parser._subparsers
        for name, action in parser._option_string_actions.items():
            if action.help is not argparse.SUPPRESS:
                assert (f"-l {name[2:]} " if shell == "fish" and name.startswith("--") else name.lstrip("-")) in script
    for name in SETTING_KEYS:
        assert f"{name}=" in script


@pytest.mark.skipif(os.name == "nt", reason="bash is no shell of Windows")
def test_bash_completes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bash = shutil.which("bash")
    assert bash is not None
    script = tmp_path / "dps-s"
    script.write_text(printed("bash", capsys), encoding="utf-8")
    (tmp_path / "my profile.toml").touch()

    def completed(*words: str) -> list[str]:
        done = subprocess.run(
            [bash, "--norc", "-c", _ASK, "bash", str(script), *words],
            cwd=tmp_path, text=True, capture_output=True, timeout=60, check=True,
        )  # fmt: skip
        assert done.stderr == ""
        return [line for line in done.stdout.splitlines() if line]

    assert sorted(completed("")) == sorted(entry.name for entry in ENTRIES)
    assert completed("mon") == ["monitor"]
    assert completed("recordings", "ex") == ["export"]
    assert completed("recordings", "export", "--q") == ["--quiet"]
    assert completed("read", "--baud", "9") == ["9600"]
    assert completed("read", "--j") == ["--json"]
    assert sorted(completed("set", "freefall_t")) == ["freefall_time_s=", "freefall_trigger="]
    assert completed("set", "freefall_trigger", "=") == ["true", "false"]
    assert completed("set", "freefall_trigger", "=", "f") == ["false"]
    assert completed("set", "freefall_time_s", "=", "") == []
    assert completed("set", "--profile", "my") == ["my profile.toml"]
    assert completed("completion", "z") == ["zsh"]
    assert completed("decode", "--asked", "cell") == ["cell_voltage"]
    assert completed("schema", "mo") == ["monitor"]


def test_another_shell_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert "csh" in run_here(capsys, ["completion", "csh"], 2).err
