"""Habits of command lines: short options, suggestions, colours, a usage of the command's own."""

import argparse
import os
import signal
import sys
from collections.abc import Iterable

import pytest

from app.cli.commands import BY_NAME, ENTRIES, SubCommand
from app.store.fact_store import Store
from app.terminal import console
from app.terminal import records as command_journal
from app.terminal.console import Refused
from tests.support.cli_line import Program

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")


def test_the_help_lists_every_command(dps_s: Program) -> None:
    told = dps_s(["--help"]).out
    rows = [line.split()[0] for line in told.splitlines() if line.startswith("  ") and not line.startswith("  -")]
    assert rows == [entry.name for entry in ENTRIES]


@pytest.mark.parametrize("entry", ENTRIES, ids=[entry.name for entry in ENTRIES])
def test_every_command_shows_an_example_that_it_takes(entry: SubCommand, dps_s: Program) -> None:
    told = dps_s([entry.name, "--help"]).out
    assert f"Example: dps-s {entry.name} {entry.example}".strip() in told
    entry.parse_words(entry.example.split())


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
    emit = console.emit

    def interrupted(args: argparse.Namespace, answer: object, page: Iterable[console.Line]) -> None:
        os.kill(os.getpid(), signal.SIGTERM)
        emit(args, answer, page)

    monkeypatch.setattr(console, "emit", interrupted)
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
