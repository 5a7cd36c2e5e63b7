"""Habits of command lines: short options, suggestions, colours, a usage of the command's own."""

import io
import json
import os
import signal
import sys

import pytest

from app import __main__ as program
from app.cli import set as setting
from app.cli.commands import BY_NAME, ENTRIES, SubCommand
from app.procedures.write import WriteReport
from app.store.fact_store import Store
from app.terminal import console
from app.terminal import records as command_journal
from app.terminal.console import Refused
from tests.support.cli_line import Program

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")


def test_the_help_lists_every_command_in_a_group(dps_s: Program) -> None:
    told = dps_s(["--help"]).out
    rows = [line.split()[0] for line in told.splitlines() if line.startswith("  ") and not line.startswith("  -")]
    assert rows == [entry.name for entry in ENTRIES]
    assert [line for line in told.splitlines() if line in ("Module:", "Settings:", "Program:")]


@pytest.mark.parametrize("entry", ENTRIES, ids=[entry.name for entry in ENTRIES])
def test_every_command_shows_an_example_that_it_takes(entry: SubCommand, dps_s: Program) -> None:
    told = dps_s([entry.name, "--help"]).out
    assert f"Example: dps-s {entry.example}" in told
    assert entry.example.startswith(entry.name)
    entry.parse_words(entry.example.split()[1:])


@pytest.mark.parametrize(
    ("words", "attribute"),
    [("set a=1 --json b=2", "wishes"), ("decode 41 --json 75", "hex"), ("fired a --must b", "logs")],
)
def test_options_may_stand_between_other_words(words: str, attribute: str) -> None:
    name, first, _, last = words.split()
    entry = BY_NAME[name]
    assert getattr(entry.parse_words(words.split()[1:]), attribute) == [first, last]
    with pytest.raises(Refused) as refused:
        entry.parse_words(["--nonsense"])
    assert refused.value.sentence.startswith(f"usage: dps-s {name} ")


def test_colours_only_on_a_terminal_that_takes_them(port: str, dps_s: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    words = ["set", "freefall_time_s=0.1", "light_threshold_v=2", "--accept-risk", "--port", f"{port}?mute_codes=22"]
    assert "\x1b" not in dps_s(words, 1).out
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    monkeypatch.setenv("WT_SESSION", "1")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    bad, good = dps_s(words, 1).out.splitlines()
    assert bad.startswith("\x1b[31mfreefall_time_s ")
    assert good.startswith("\x1b[32mlight_threshold_v ")
    assert bad.endswith("\x1b[0m")
    monkeypatch.setenv("NO_COLOR", "1")
    assert "\x1b" not in dps_s(words, 1).out


@pytest.mark.skipif(os.name == "nt", reason="no such signal")
def test_a_signal_after_the_last_frame_does_not_keep_the_result(
    port: str, dps_s: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    page_of = setting.page_of

    def interrupted_page(report: WriteReport) -> list[str]:
        os.kill(os.getpid(), signal.SIGTERM)
        return page_of(report)

    monkeypatch.setattr(setting, "page_of", interrupted_page)
    default = signal.signal(signal.SIGTERM, lambda *_: pytest.fail("the signal would have ended the program"))
    try:
        assert "1.4: verified" in dps_s(["set", "freefall_time_s=1.4", "--port", port]).out
    finally:
        signal.signal(signal.SIGTERM, default)


@pytest.mark.skipif(os.name == "nt", reason="no such signal")
@pytest.mark.parametrize("words", [["set", "freefall_time_s=1.4"], ["activate", "--yes"]])
def test_a_signal_before_the_port_is_opened_keeps_everything_from_being_sent(
    words: list[str], port: str, dps_s: Program, monkeypatch: pytest.MonkeyPatch, wire: list[bytes]
) -> None:
    def interrupted_open(*, starts_late: bool = False) -> Store:
        os.kill(os.getpid(), signal.SIGTERM)
        return Store(starts_late=starts_late)

    monkeypatch.setattr(command_journal, "Store", interrupted_open)
    dps_s([*words, "--port", port], 128 + signal.SIGTERM)
    assert wire == []


@pytest.mark.skipif(os.name == "nt", reason="there a process sends Ctrl-C to its whole group")
def test_an_impatient_second_ctrl_c_leaves_the_error_object_whole(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(_words: list[str]) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(program, "_run", interrupted)
    monkeypatch.setattr(console, "notify", lambda _sentence: os.kill(os.getpid(), signal.SIGINT))
    assert program.main(["read", "--json"]) == 130
    assert json.loads(capsys.readouterr().out)["error"]["code"] == "cancelled"


@pytest.mark.parametrize(
    ("typed", "name"), [("M-07\n", "M-07"), ("伞仓 07\r\nrest", "伞仓 07"), ("M-08", "M-08"), ("\n", None), ("", None),
                        ("M" * 201 + "\n", None)],
)  # fmt: skip
def test_a_scanner_types_the_name_of_the_module(typed: str, name: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO(typed, newline=None))
    parse = BY_NAME["preflight"].parse_words
    words = ["--module", "-", "--enable-triggers"]
    if name is not None:
        assert parse(words).module == name
        return
    with pytest.raises(Refused, match="expected NAME"):
        parse(words)
