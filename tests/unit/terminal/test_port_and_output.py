"""A pipe that nobody reads, the port of a command that was given none, and -v."""

import json
import os
import signal
import sys

import pytest

from app.__main__ import PORT
from app.engine import ports as port_list
from app.engine.ports import PortInfo
from app.terminal import console as interruption
from app.terminal.console import write
from tests.support.cli_line import Program

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "user_files")


@pytest.mark.skipif(not hasattr(signal, "SIGALRM"), reason="Windows has no alarm")
def test_a_pipe_that_nobody_reads_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interruption, "PATIENCE_S", 0.1)
    reading, writing = os.pipe()
    with open(writing, "w", encoding="utf-8") as out:  # noqa: PTH123
        monkeypatch.setattr(sys, "stdout", out)
        with interruption.signals_noted():
            signal.raise_signal(signal.SIGINT)
            with pytest.raises(interruption.Signalled):
                write("x" * 2_000_000)  # more than a pipe holds
        monkeypatch.undo()
    os.close(reading)


# Port of a command that was given none, and what is said on standard error.


ADAPTER = PortInfo("sim://only", "CP2102", vid=0x10C4, pid=0xEA60)
OTHER = PortInfo("/dev/ttyUSB9", "CH340", vid=0x1A86, pid=0x7523)
BOARD = PortInfo("/dev/ttyS0")


def found(monkeypatch: pytest.MonkeyPatch, *ports: PortInfo) -> None:
    monkeypatch.delenv(PORT, raising=False)
    monkeypatch.setattr(port_list, "list_ports", lambda: list(ports))


def test_the_only_adapter_is_taken_and_named(monkeypatch: pytest.MonkeyPatch, dps_s: Program) -> None:
    found(monkeypatch, BOARD, ADAPTER)
    printed = dps_s(["find", "--json"])
    assert json.loads(printed.out)["baud_rate"] == 115200
    assert printed.err == "Port sim://only (CP2102)\n"


def test_the_environment_names_it(port: str, monkeypatch: pytest.MonkeyPatch, dps_s: Program) -> None:
    found(monkeypatch, ADAPTER, OTHER)
    monkeypatch.setenv(PORT, port)
    printed = dps_s(["find"])
    assert printed.out == f"{port}, 115200 baud\n"
    assert printed.err == f"Port {port} (DPS_S_PORT)\n"
    assert dps_s(["find", "--quiet"]).err == ""


@pytest.mark.parametrize(
    ("words", "ports", "code", "said"),
    [
        (["activate", "--yes"], (ADAPTER, OTHER), 2,
         "There are several adapters: sim://only, /dev/ttyUSB9. Give --port.\n"),
        (["read"], (), 3, "There is no USB adapter. Plug it in, or give --port.\n"),
        (["read"], (BOARD,), 3, "There is no USB adapter. Plug it in, or give --port.\n"),
        (["zero"], (), 2, "Nothing was done. Add --yes to do it.\n"),  # looks for no port
    ],
)  # fmt: skip
def test_without_the_only_adapter_none_is_taken(
    words: list[str], ports: tuple[PortInfo, ...], code: int, said: str, monkeypatch: pytest.MonkeyPatch, dps_s: Program
) -> None:
    found(monkeypatch, *ports)
    assert dps_s(words, code).err == said


@pytest.mark.parametrize("words", [["-v", "find"], ["find", "-v"], ["find", "--verbose", "--json"]])
def test_verbose_says_what_is_asked(words: list[str], port: str, dps_s: Program) -> None:
    printed = dps_s([*words, "--port", port])
    assert f"{port}  115200 baud, open" in printed.err
    assert "the module answers" in printed.err
    assert "41 75" not in printed.err
    assert printed.out.count("\n") == 1


def test_twice_verbose_shows_every_frame_once(port: str, wire: list[bytes], dps_s: Program) -> None:
    lines = dps_s(["-vv", "read", "--port", port, "--json"]).err.splitlines()
    sent = [line for line in lines if " > 42 61 " in line]
    assert [bytes.fromhex(line.split(" > ")[1][:17]) for line in sent] == wire
    assert sum(" < 41 75 " in line for line in lines) == len(wire)
    assert any("status: tilt 0°" in line for line in lines)
