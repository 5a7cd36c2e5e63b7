"""What the commands print, send and end with: as `goldens.txt` and docs/command-line.md say, and byte for byte."""

import doctest
import io
import json
import os
import re
import shlex
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import closing, redirect_stderr, redirect_stdout
from itertools import count
from pathlib import Path
from typing import Any, Final, NamedTuple

import pytest

import app.__main__ as program
from app.cli.commands import ENTRIES
from app.cli.schema import SCHEMAS, schema_of
from app.port_urls.protocol_sim import open_bench
from app.simulator.bench import SimulatedBench
from app.simulator.setup import Setup
from app.store.rows import PreflightCheck
from app.terminal.console import RATES
from protocol.catalogue import BAUD_RATES
from protocol.messages import decode_request
from tests.support.cli_line import Program, faults
from tests.support.line.frames import lose, refuse
from tests.support.records.stored import open_store
from tests.support.virtual_cli import VirtualCli
from tests.unit.simulator.test_simulator_servers import posix_only

pytest_plugins = ["tests.support.cli_fixtures"]

GOLDENS: Final = Path(__file__).with_name("goldens.txt")
PAGE: Final = Path(__file__).parents[2] / "docs" / "command-line.md"
SHOWN_PORT: Final = "/tmp/dps-s"
IS_WRITING: Final = os.environ.get("GOLDENS") == "write"
_ports = count()
_BLOCK = re.compile(r"```console\n(.*?)```", re.DOTALL)
_COMMAND = re.compile(r"^\$ dps-s ", re.MULTILINE)
_VARYING: Final = (
    (r'("round_trip_ms": )[\d.]+', r"\1…"),
    (r"\d+\.\d ms\b", "… ms"),
    (r"^! \d+\.\d{6}", "! …"),
    (r"\d{8}T\d{6}Z-", "…-"),
    (r"(Rows: )\d+", r"\1…"),
    (r"\d{4}-\d\d-\d\d[ T]\d\d:\d\d(:\d\d([.+]\S*)?)?", "…"),
    (r"[0-9A-F]{4}(-[0-9A-F]{4}){4}", "FINGERPRINT"),
    (r"^! usage: (dps-s( [a-z]+)*).*\n(! {2,}.*\n)*", r"! usage: \1 …\n"),
    (r"'(?=[^(\n]*\))", ""),  # of choices
)
"""Times, the key of the station, and what Pythons lay out each in their way."""
HAN: Final = r"[一-鿿]"


class Example(NamedTuple):
    """`line`: what is typed behind `dps-s`."""

    line: str
    said: str


Examples = tuple[Example, ...]


def examples_in(text: str) -> Examples:
    return tuple(Example(line, said) for line, _, said in (one.partition("\n") for one in _COMMAND.split(text)[1:]))


def sections() -> list[Any]:
    parts = GOLDENS.read_text(encoding="utf-8").split("=== ")[1:]
    return [pytest.param(examples_in(part), id=part.partition("\n")[0]) for part in parts]


class _Messages(io.StringIO):
    """Standard error with each line marked, among standard output."""

    def __init__(self, shown: io.StringIO) -> None:
        super().__init__()
        self._shown = shown

    def write(self, text: str) -> int:
        return self._shown.write(re.sub(r"^(?=.)", "! ", text, flags=re.MULTILINE))


def say(words: list[str], *, is_marked: bool) -> str:
    """What a terminal shows, and the exit code where it is not 0."""
    shown = io.StringIO()
    with redirect_stdout(shown), redirect_stderr(_Messages(shown) if is_marked else shown):
        code = program.main(words)
    return shown.getvalue() + (f"(exit code {code})\n" if code else "")


def spoil(url: str) -> None:
    """As its name says, a module streams, refuses, or neither answers a code nor obeys it."""
    name = url.partition("?")[0].rpartition("-")[2]
    if name == "streams":
        module = open_bench(url)
        module.module.start_stream(module.clock())
    elif name == "refuses":
        refuse(open_bench(url))
    elif name.startswith("not"):
        lose(open_bench(url), int(name.removeprefix("not"), 16))


def run_section(section: Examples, wire: list[bytes]) -> Iterator[Example]:
    """What is said now. What varies is replaced; JSON is held against its schema."""
    port = f"sim://golden{next(_ports):03}"  # of one length, for the columns
    for line, _ in section:
        words = shlex.split(line.replace("PORT", port))
        for url in (word for word in words if word.startswith(f"{port}-")):
            spoil(url)
        wire.clear()
        said = say(words, is_marked=True)
        name = next((name for name in ("_".join(words[:2]), words[0]) if name in SCHEMAS), None)
        if "--json" in words and name is not None:
            lines = [line for line in said.splitlines() if not line.startswith(("! ", "(exit code "))]
            assert [fault for line in lines for fault in faults(name, json.loads(line))] == []
        sent = [request for request in map(decode_request, wire) if not request.is_repeatable]
        names = ", ".join(f"{request.command.name} {request.data}" for request in sent)
        said = said.replace("\r", "\\r") + (f"(sent {names})\n" if sent else "")
        said = said.replace(port, "PORT").replace(os.environ["HOME"], "HOME")
        for pattern, shown in _VARYING:
            said = re.sub(pattern, shown, said, flags=re.MULTILINE)
        yield Example(line, said)


def as_text(examples: Iterator[Example] | tuple[Example, ...]) -> str:
    return "".join(f"$ dps-s {line}\n{said}" for line, said in examples).rstrip("\n")


@posix_only
@pytest.mark.usefixtures("speaks_english", "user_files", "no_waiting")
@pytest.mark.parametrize("section", sections())
@pytest.mark.promise("d", "f", "g", "i")
def test_what_is_said_and_sent(
    section: Examples, wire: list[bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    says, said = as_text(run_section(section, wire)), as_text(section)
    if IS_WRITING:
        GOLDENS.write_text(GOLDENS.read_text(encoding="utf-8").replace(said, says), encoding="utf-8")
    else:
        assert says == said


@pytest.mark.usefixtures("user_files", "no_waiting")
def test_results_and_errors_are_translated_and_names_are_not(
    port: str, dps_s: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LC_ALL", "zh_CN.UTF-8")
    lose(open_bench(port), 0x22)
    printed = dps_s(["set", "freefall_time_s=1.2", "--port", port], 1)
    assert re.search(HAN, printed.out)
    assert printed.out.startswith("freefall_time_s ")
    assert re.search(HAN, dps_s(["recordings", "list"]).err)


@pytest.mark.usefixtures("speaks_english", "user_files")
def test_every_example_says_what_the_page_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.chdir(tmp_path)
    text, judge, cli = PAGE.read_text(encoding="utf-8"), doctest.OutputChecker(), VirtualCli()
    with cli.in_time():
        cli.served[SHOWN_PORT] = SimulatedBench(Setup(history=2))
        for block in _BLOCK.findall(text):
            found = []
            for line, said in examples_in(block):
                says = say(shlex.split(line), is_marked=False)
                is_as_said = judge.check_output(said, says, doctest.ELLIPSIS)
                found.append(Example(line, said if is_as_said else says))
                assert is_as_said or IS_WRITING, f"dps-s {line} says now:\n{says}"
            text = text.replace(block, as_text(tuple(found)) + "\n")
    if IS_WRITING:
        PAGE.write_text(text, encoding="utf-8")


def test_rates_are_those_of_the_catalogue() -> None:
    assert RATES == BAUD_RATES


# Schemas


@pytest.mark.parametrize("name", SCHEMAS)
def test_the_command_prints_a_valid_schema(name: str, dps_s: Program) -> None:
    from jsonschema import Draft202012Validator

    printed = json.loads(dps_s(["schema", name]).out)
    Draft202012Validator.check_schema(printed)
    assert printed == schema_of(name)


@pytest.mark.usefixtures("user_files", "hasty", "no_waiting")
def test_what_varies_is_as_its_schema_says(port: str, tmp_path: Path, dps_s: Program) -> None:
    dps_s(["record", "--port", port, "--seconds", "0.1", str(tmp_path / "a.csv")])
    for words in (["ports"], ["recordings", "list"], ["monitor", "--port", port, "--seconds", "0.2"]):
        lines = dps_s([*words, "--json"]).out.splitlines()
        assert lines
        assert [fault for line in lines for fault in faults(words[0], json.loads(line))] == []
    dps_s(["preflight", "--port", f"{port}-b?history=2", "--enable-triggers", "--module", "M-07"], 1)
    with closing(open_store()) as store:
        (check,) = store.read(lambda facts: facts.of_kind(PreflightCheck))
    assert faults("record", json.loads(check.content.document)) == []


# Completion scripts know every command and option; the one for bash is run by bash.

_ASK = """
source "$1"; shift
COMP_WORDS=(dps-s "$@"); COMP_CWORD=$(($#))
_shtab_dps_s 2>/dev/null
printf '%s\\n' "${COMPREPLY[@]}"
"""


def test_the_script_for_zsh_knows_every_command(dps_s: Program) -> None:
    script = dps_s(["completion", "zsh"]).out
    assert [entry.name for entry in ENTRIES if entry.name not in script] == []


@pytest.mark.skipif(os.name == "nt", reason="bash is no shell of Windows")
def test_bash_completes(tmp_path: Path, dps_s: Program) -> None:
    bash = shutil.which("bash")
    assert bash is not None
    script = tmp_path / "dps-s"
    text = dps_s(["completion", "bash"]).out
    script.write_text(text.replace("/dev/ttyUSB*", str(tmp_path / "tty*")), encoding="utf-8")
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
