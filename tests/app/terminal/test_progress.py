"""Progress on a terminal: only for what takes longer than half a second, and gone afterwards."""

import io
from argparse import Namespace
from contextlib import redirect_stderr
from types import SimpleNamespace

import pytest

import app.__main__ as program
from app.terminal import console

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "user_files")


class Terminal(io.StringIO):
    """Standard error that is a terminal."""

    def isatty(self) -> bool:
        return True

    @property
    def left(self) -> str:
        """What still stands there: the last line, without what was wiped."""
        return self.getvalue().rpartition("\n")[2].rpartition("\r")[2].removesuffix("\x1b[K")


@pytest.fixture
def terminal() -> Terminal:
    console.set_verbosity(Namespace())
    console.clear_progress()
    return Terminal()


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    now = [100.0]
    monkeypatch.setattr("app.terminal.console.time", SimpleNamespace(monotonic=lambda: now[0]))
    return now


def test_what_is_done_soon_shows_nothing(terminal: Terminal, clock: list[float]) -> None:
    with redirect_stderr(terminal):
        for _ in range(4):
            console.show_progress("reading")
            clock[0] += 0.1
        console.clear_progress()
        clock[0] += 1.0
        console.show_progress("something else")
        assert terminal.getvalue() == ""
        console.clear_progress()


def test_what_takes_longer_is_shown_and_taken_away(terminal: Terminal, clock: list[float]) -> None:
    with redirect_stderr(terminal):
        console.show_progress("reading")
        clock[0] += 0.5
        console.show_progress("reading")
        assert terminal.left == "reading"
        shown = terminal.getvalue()
        console.show_progress("reading")
        assert terminal.getvalue() == shown
        console.show_progress("writing")
        assert terminal.left == "writing"
        console.clear_progress()
        assert terminal.left == ""


def test_a_sentence_takes_its_place(terminal: Terminal, clock: list[float], capsys: pytest.CaptureFixture[str]) -> None:
    with redirect_stderr(terminal):
        console.show_progress("reading")
        clock[0] += 1.0
        console.show_progress("reading")
        console.notify("There is no port.")
        assert terminal.getvalue().endswith("\r\x1b[KThere is no port.\n")
        console.show_progress("reading")
        console.write_lines(["a result"])
        assert terminal.left == ""
        console.clear_progress()


def test_elsewhere_there_is_none(clock: list[float], capsys: pytest.CaptureFixture[str]) -> None:
    console.show_progress("reading")
    clock[0] += 1.0
    console.show_progress("reading")
    console.clear_progress()
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("words", [["--json"], ["--quiet", "--json"]])
def test_what_is_being_read_is_said_meanwhile(
    words: list[str], port: str, terminal: Terminal, capsys: pytest.CaptureFixture[str], hasty: None
) -> None:
    with redirect_stderr(terminal):
        assert program.main(["read", "--port", f"{port}?mute_codes=34", *words]) == 4
        assert ("Reading: Cell voltage (9/9)" in terminal.getvalue()) is ("--quiet" not in words)
        assert terminal.left == ""
        assert capsys.readouterr().out.count("\n") == 1
