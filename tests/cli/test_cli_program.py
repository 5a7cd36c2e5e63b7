"""No link, used wrongly, errors of our own: a sentence and an exit code, never a traceback."""

import argparse
import errno
import json
import os
import re
import sys
import threading
from pathlib import Path

import pytest
import serial

import app.__main__ as program
from app.engine import ports as port_list
from app.engine.ports import NOT_LISTED
from app.engine.procedure import Inspect, Procedure
from app.procedures.history import History
from app.terminal import connection
from app.text.i18n import read_translations
from app.text.messages import UserError
from tests.cli.test_schemas import faults
from tests.support.cli_line import Printed, Program, is_one_sentence
from tests.support.setup_files import tool

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")


def test_a_port_that_hangs_in_opening(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    release = threading.Event()

    def hang(self: serial.Serial) -> None:
        release.wait()
        raise OSError(errno.ENOENT, "gone")

    monkeypatch.setattr(connection, "OPENING_LIMIT_S", 0.3)
    monkeypatch.setattr(serial.Serial, "open", hang)
    try:
        assert program.main(["read", "--port", "/dev/ttyS9"]) == 3
    finally:
        release.set()
    printed = Printed(capsys)
    assert "/dev/ttyS9 does not open within" in printed.err
    assert is_one_sentence(printed.err)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ([], {"demo": False, "port": None, "baud": 115200, "lang": None}),
        (["--demo"], {"demo": True}),
        (["gui", "--port", "P", "--baud", "9600", "--lang", "zh_CN"], {"port": "P", "baud": 9600, "lang": "zh_CN"}),
        (["--offscreen-seconds", "2.5"], {"offscreen_seconds": 2.5}),
    ],
)
def test_without_a_command_the_window_opens(
    words: list[str], expected: dict[str, object], monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[dict[str, object]] = []

    def open_window(args: argparse.Namespace) -> int:
        opened.append(vars(args))
        return 0

    monkeypatch.setattr("app.cli.gui.run", open_window)
    assert program.main(words) == 0
    assert {name: opened[0][name] for name in expected} == expected


def test_an_error_of_our_own_is_one_calm_line(dps_s: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_args: argparse.Namespace) -> int:
        raise ZeroDivisionError("a bug")

    monkeypatch.setattr("app.cli.ports.run", fail)
    printed = dps_s(["ports"], 1)
    assert printed.out == ""
    assert "a bug" in printed.err
    assert printed.err.count("\n") == 1


def test_ports_for_programs_and_people(dps_s: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    one = port_list.PortInfo("/dev/ttyUSB0", "CP2102", "Silicon Labs", "0001", 0x10C4, 0xEA60, "1-2")
    monkeypatch.setattr("app.cli.ports.list_ports", lambda: [one])
    told = json.loads(dps_s(["ports", "--json"]).out)
    assert told == {"ports": [one._asdict()]}
    assert faults("ports", told) == []
    assert "/dev/ttyUSB0  CP2102  Silicon Labs  0001           10c4:ea60" in dps_s(["ports"]).out


def test_no_ports_and_no_list(dps_s: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.cli.ports.list_ports", list)
    assert "No serial port." in dps_s(["ports"]).err

    def fail() -> list[port_list.PortInfo]:
        raise UserError(NOT_LISTED)

    monkeypatch.setattr("app.cli.ports.list_ports", fail)
    assert json.loads(dps_s(["ports", "--json"], 3).out)["error"]["code"] == "no_port"
    assert "lists no serial ports" in dps_s(["ports"], 3).err


@pytest.mark.parametrize(
    ("words", "code"),
    [(["preflight", "--json"], 4), (["-v", "lock", "--yes"], 4), (["diff", "p.toml"], 4), (["read"], 4)],
)
def test_a_reader_that_ended_takes_no_answer_for_yes(
    words: list[str], code: int, port: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "p.toml").write_text('name = "x"\n[settings]\nfreefall_time_s = 1.9\n', encoding="utf-8")
    reading, writing = os.pipe()
    os.close(reading)
    with open(writing, "w", encoding="utf-8") as out:  # noqa: PTH123
        monkeypatch.setattr(sys, "stdout", out)
        assert program.main([*words, "--port", port]) == code
        monkeypatch.undo()


def test_records_that_never_agree_are_said_to_be_uncertain(
    port: str, dps_s: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    def read_history() -> Procedure[History]:
        yield Inspect()
        return History((), 1, is_answered=True)

    monkeypatch.setattr("app.trigger_records.history.read_history", read_history)
    printed = dps_s(["history", "--port", port, "--json"], 4)
    assert json.loads(printed.out) == {"records": [], "empty_slots": 1, "answered": True, "complete": False}
    assert "may be missing" in printed.err


# Chinese on the command line has full-width punctuation throughout.


_HAN = r"[一-鿿]"
HALF_WIDTH = re.compile(
    rf"{_HAN}[,;:!?]|{_HAN} ?\(|\({_HAN}|{_HAN}\)|[,;!?]{_HAN}|[。，；：！？、] (?=[^\s→])|{_HAN}\.(?:\s|$)",
    re.MULTILINE,
)
"""A half-width mark beside a Chinese character, or a space behind a full-width one; two spaces part columns."""


def half_width(text: str) -> list[str]:
    return [text[max(0, found.start() - 12) : found.end() + 12] for found in HALF_WIDTH.finditer(text)]


def test_no_translation_has_one() -> None:
    texts = read_translations(tool("docs/generate", "translations").TS)
    places = {chinese: re.sub(r" \(\*[^)]*\)|\(&[A-Z]\)|主机:端口", "", chinese) for chinese in texts.values()}
    assert {chinese: half_width(text) for chinese, text in places.items() if half_width(text)} == {}
