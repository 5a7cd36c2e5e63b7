"""Port of a command that was given none, and what is said on standard error."""

import json

import pytest

import app.__main__ as program
from app.engine import ports as port_list
from app.engine.ports import NOT_LISTED, PortInfo
from app.terminal.port_choice import PORT
from app.text.user_error import UserError
from tests.support.cli_line import Printed, run_here

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "user_files")

ADAPTER = PortInfo("sim://only", "CP2102", vid=0x10C4, pid=0xEA60)
OTHER = PortInfo("/dev/ttyUSB9", "CH340", vid=0x1A86, pid=0x7523)
BOARD = PortInfo("/dev/ttyS0")


def found(monkeypatch: pytest.MonkeyPatch, *ports: PortInfo) -> None:
    monkeypatch.delenv(PORT, raising=False)
    monkeypatch.setattr(port_list, "list_ports", lambda: list(ports))


def test_the_only_adapter_is_taken_and_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found(monkeypatch, BOARD, ADAPTER)
    printed = run_here(capsys, ["find", "--json"])
    assert json.loads(printed.out)["baud_rate"] == 115200
    assert printed.err == "Port sim://only (CP2102)\n"


def test_the_environment_names_it(
    port: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found(monkeypatch, ADAPTER, OTHER)
    monkeypatch.setenv(PORT, port)
    printed = run_here(capsys, ["find"])
    assert printed.out == f"{port}, 115200 baud\n"
    assert printed.err == f"Port {port} (DPS_S_PORT)\n"
    assert run_here(capsys, ["find", "--quiet"]).err == ""


def test_of_several_none_is_taken(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    found(monkeypatch, ADAPTER, OTHER)
    assert program.main(["activate", "--yes"]) == 2
    assert Printed(capsys).err == "There are several adapters: sim://only, /dev/ttyUSB9. Give --port.\n"


@pytest.mark.parametrize("ports", [(), (BOARD,)])
def test_without_an_adapter_there_is_no_link(
    ports: tuple[PortInfo, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found(monkeypatch, *ports)
    assert "There is no USB adapter." in run_here(capsys, ["read"], 3).err


def test_where_the_system_lists_none_nothing_is_taken(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse() -> list[PortInfo]:
        raise UserError(NOT_LISTED)

    found(monkeypatch)
    monkeypatch.setattr(port_list, "list_ports", refuse)
    assert "did not list its serial ports" in run_here(capsys, ["read"], 3).err


def test_an_act_without_yes_looks_for_no_port(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found(monkeypatch)
    assert run_here(capsys, ["lock"], 2).err == "Nothing was done. Add --yes to do it.\n"


@pytest.mark.parametrize("words", [["-v", "find"], ["find", "-v"], ["find", "--verbose", "--json"]])
def test_verbose_says_what_is_asked(words: list[str], port: str, capsys: pytest.CaptureFixture[str]) -> None:
    printed = run_here(capsys, [*words, "--port", port])
    assert f"{port}  115200 baud" in printed.err
    assert "Heartbeat  " in printed.err
    assert "41 75" not in printed.err
    assert printed.out.count("\n") == 1


def test_twice_verbose_shows_every_frame_once(port: str, wire: list[bytes], capsys: pytest.CaptureFixture[str]) -> None:
    lines = run_here(capsys, ["-vv", "read", "--port", port, "--json"]).err.splitlines()
    sent = [line for line in lines if " > 42 61 " in line]
    assert [bytes.fromhex(line.split(" > ")[1][:17]) for line in sent] == wire
    assert sum(" < 41 75 " in line for line in lines) == len(wire)
    assert any("status: tilt 0°" in line for line in lines)


def test_nested_commands_take_them_too(capsys: pytest.CaptureFixture[str]) -> None:
    assert "No recordings yet" in run_here(capsys, ["recordings", "list"]).err
    assert program.main(["recordings", "list", "--quiet"]) == 0
    assert run_here(capsys, ["--quiet", "recordings", "list"]).err == ""
