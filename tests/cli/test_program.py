"""The program as such: its words, ports and signals, errors of our own, hostile input; a sentence, no traceback."""

import argparse
import errno
import json
import os
import re
import signal
import sys
import threading
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path

import pytest
import serial
from serial.tools.list_ports_common import ListPortInfo

import app.__main__ as program
from app.cli.commands import ENTRIES, SubCommand
from app.engine import ports as port_list
from app.engine.ports import NOT_LISTED, PortInfo
from app.engine.procedure import Inspect, Procedure
from app.engine.transport import PortError, PortErrorKind, open_line
from app.procedures.history import History
from app.store.fact_store import Store
from app.store.rows import PreflightCheck
from app.system.files import write_whole
from app.terminal import connection, console
from app.text.messages import visible
from protocol.messages import TriggerRecord, decode_record
from tests.support.cli_line import Program
from tests.support.patience import in_time
from tests.support.processes import PROGRAM, ROOT, ran
from tests.support.records.stored import open_store
from ui.main import WindowOptions

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "user_files")
ESCAPE = "\x1b]0;owned\x07\x9b31m\u202e\u2066"


# Words


def test_the_help_lists_every_command(dps_s: Program) -> None:
    told = dps_s(["--help"]).out
    assert re.findall(r"^    ([a-z]+) ", told, re.MULTILINE) == [entry.name for entry in ENTRIES]


@pytest.mark.parametrize("entry", ENTRIES, ids=[entry.name for entry in ENTRIES])
def test_every_command_shows_an_example_that_it_takes(entry: SubCommand, dps_s: Program) -> None:
    assert f"Example: dps-s {entry.name} {entry.example}".strip() in dps_s([entry.name, "--help"]).out
    entry.parse_words(entry.example.split())


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("", {"demo": False, "port": None, "baud_rate": 115200, "language": None}),
        ("gui --port P --baud 9600 --lang zh_CN", {"port": "P", "baud_rate": 9600, "language": "zh_CN"}),
        ("--offscreen-seconds 2.5", {"offscreen_seconds": 2.5}),
    ],
)
def test_without_a_command_the_window_opens(
    words: str, expected: dict[str, object], monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[dict[str, object]] = []

    def open_window(args: argparse.Namespace) -> int:
        opened.append(vars(args))
        return 0

    monkeypatch.setattr("app.cli.gui.run", open_window)
    assert program.main(words.split()) == 0
    assert {name: opened[0][name] for name in expected} == expected


def test_a_file_opens_the_window_on_it_where_it_is_there(dps_s: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[Path | None] = []

    def run(options: WindowOptions) -> int:
        opened.append(options.file)
        return 0

    monkeypatch.setattr("ui.main.run", run)
    for words in (["pyproject.toml"], ["gui", "pyproject.toml"], ["pyproject.toml", "--demo"]):
        dps_s(words)
        assert opened.pop() == Path("pyproject.toml")
    assert "nowhere.toml cannot be read: No such file or directory." in dps_s(["nowhere.toml"], 2).err
    assert "There is no command bogus." in dps_s(["bogus"], 2).err
    assert opened == []


# Ports


ADAPTER = PortInfo("sim://only", "CP2102", vid=0x10C4, pid=0xEA60)
OTHER = PortInfo("/dev/ttyUSB9", "CH340", vid=0x1A86, pid=0x7523)
BOARD = PortInfo("/dev/ttyS0")


@pytest.mark.parametrize(
    ("words", "named", "adapters", "code", "said"),
    [
        ("find", "", (BOARD, ADAPTER), 0, "Port sim://only (CP2102)\n"),
        ("find", "sim://named", (ADAPTER, OTHER), 0, "Port sim://named (DPS_S_PORT)\n"),
        ("find --quiet", "sim://named", (), 0, ""),
        ("activate --yes", "", (ADAPTER, OTHER), 2,
         "There are several adapters: sim://only, /dev/ttyUSB9. Give --port.\n"),
        ("read", "", (BOARD,), 3, "There is no USB adapter. Plug it in, or give --port.\n"),
        ("zero", "", (), 2, "Nothing was done. Add --yes to do it.\n"),  # looks for no port
    ],
)  # fmt: skip
def test_the_only_adapter_is_taken_unless_the_environment_names_a_port(
    words: str, named: str, adapters: tuple[PortInfo, ...], code: int, said: str, monkeypatch: pytest.MonkeyPatch,
    dps_s: Program,
) -> None:  # fmt: skip
    monkeypatch.setenv(program.PORT, named)
    monkeypatch.setattr(port_list, "list_ports", lambda: list(adapters))
    printed = dps_s(words.split(), code)
    assert printed.err == said
    if code == 0:
        assert printed.out == f"{named or ADAPTER.device}, 115200 baud\n"


def test_ports_for_programs_and_people(dps_s: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    one = PortInfo("/dev/ttyUSB0", "CP2102", "Silicon Labs", "0001", 0x10C4, 0xEA60, "1-2")
    found = ListPortInfo(one.device)
    vars(found).update(one._asdict(), product=one.description, description="n/a", manufacturer=one.maker)
    listed = [found]
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: listed)
    assert json.loads(dps_s(["ports", "--json"]).out) == {"ports": [one._asdict()]}
    assert "/dev/ttyUSB0  CP2102  Silicon Labs  0001           10c4:ea60" in dps_s(["ports"]).out
    listed.clear()
    assert "No serial port." in dps_s(["ports"]).err


@pytest.mark.parametrize(
    "failing",
    ["raise SystemError('boom')", "return [object()]", "import time; time.sleep(30)"],
    ids=["error", "nonsense", "hangs"],
)
@pytest.mark.promise("k")
def test_a_failing_list_of_ports_is_reported_in_one_sentence(failing: str, tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(
        f"import serial.tools.list_ports as one\ndef comports(*_a, **_k):\n    {failing}\none.comports = comports\n",
        encoding="utf-8",
    )
    path = os.pathsep.join((str(tmp_path), str(ROOT)))
    with in_time(10.0):
        ended = ran(*PROGRAM, "ports", "--json", PYTHONPATH=path, LANGUAGE="en", LC_ALL="C.UTF-8")
    assert ended.returncode == console.NO_LINK, ended
    assert json.loads(ended.stdout)["error"]["code"] == "no_port"
    assert ended.stderr.strip() == NOT_LISTED


def test_a_port_that_hangs_in_opening(dps_s: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    release = threading.Event()

    def hang(self: serial.Serial) -> None:
        release.wait()
        raise OSError(errno.ENOENT, "gone")

    monkeypatch.setattr(connection, "OPENING_LIMIT_S", 0.3)
    monkeypatch.setattr(serial.Serial, "open", hang)
    try:
        said = dps_s(["read", "--port", "/dev/ttyS9"], 3).err
    finally:
        release.set()
    assert said == "/dev/ttyS9 does not open within 0 s. Plug the adapter in again, or check the address.\n"


@pytest.mark.parametrize(
    "address",
    ["SPY:///dev/null?file={file}", "alt:///dev/null?class=PosixPollSerial", "hwgrep://.", "cp2110://0001:004a:00",
     "nothing://x", "://", " capture://{file}"],
)  # fmt: skip
@pytest.mark.promise("g")
def test_an_address_that_writes_files_or_loads_code_is_refused(address: str, tmp_path: Path, dps_s: Program) -> None:
    address = address.format(file=tmp_path / "written")
    with pytest.raises(PortError) as refused:
        open_line(address, 115200)
    assert refused.value.kind is PortErrorKind.UNSUPPORTED
    said = dps_s(["read", "--port", address], 2).err
    assert said.count("\n") == 1
    assert "is no serial port" in said
    assert list(tmp_path.glob("written")) == []


# What is printed


def test_an_error_of_our_own_is_one_calm_line(dps_s: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_args: argparse.Namespace) -> int:
        raise ZeroDivisionError("a bug")

    monkeypatch.setattr("app.cli.ports.run", fail)
    printed = dps_s(["ports"], 1)
    assert printed.out == ""
    assert "a bug" in printed.err
    assert printed.err.count("\n") == 1


@pytest.mark.usefixtures("no_waiting", "qapp")
@pytest.mark.parametrize("words", ["preflight --report r.pdf", "preflight --json", "-v lock", "diff p.toml", "read"])
def test_a_reader_that_ended_takes_no_answer_for_yes_and_a_check_is_kept(
    words: str, port: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As `dps-s preflight … | head -0`."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "p.toml").write_text("[settings]\nfreefall_time_s = 1.9\n", encoding="utf-8")
    reading, writing = os.pipe()
    os.close(reading)
    with open(writing, "w", encoding="utf-8") as out, monkeypatch.context() as patch:  # noqa: PTH123
        patch.setattr(sys, "stdout", out)
        assert program.main([*words.split(), "--port", port]) == 4
    with closing(open_store()) as store:
        assert len(store.read(lambda facts: facts.of_kind(PreflightCheck))) == words.startswith("preflight")
    assert (tmp_path / "r.pdf").exists() is ("--report" in words)


RECORD = decode_record(bytes.fromhex("41753501 0100 6C02 3C05 A000 010C EB7E"))


def test_records_that_never_agree_are_said_to_be_uncertain(
    port: str, dps_s: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    def read_history() -> Procedure[History]:
        assert isinstance(RECORD, TriggerRecord)
        yield Inspect()
        return History((), 1, seen_once=(RECORD,), is_answered=True)

    monkeypatch.setattr("app.trigger_records.history.read_history", read_history)
    page = dps_s(["history", "--port", port], 4).out
    assert page.count("(?) ") == 2
    assert "(?) Seen in one reading only. Read again.\nEmpty slots: 1." in page
    printed = dps_s(["history", "--port", port, "--json"], 4)
    told = json.loads(printed.out)
    assert [record["confirmed"] for record in told.pop("records")] == [False]
    assert told == {"empty_slots": 1, "answered": True, "complete": False}
    assert "may be missing" in printed.err


@pytest.mark.usefixtures("no_waiting")
def test_colours_only_on_a_terminal_that_takes_them(port: str, dps_s: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    words = ["preflight", "--port", port, "--enable-triggers"]
    assert "\x1b" not in dps_s(words).out
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    monkeypatch.delenv("NO_COLOR", raising=False)
    assert dps_s(words).out.startswith("\x1b[32mREADY: activate before the flight\x1b[0m\n")
    assert dps_s(words[:-1], 1).out.startswith("\x1b[31mNO-GO")
    monkeypatch.setenv("NO_COLOR", "1")
    assert "\x1b" not in dps_s(words).out


def test_twice_verbose_shows_every_frame_once(port: str, wire: list[bytes], dps_s: Program) -> None:
    lines = dps_s(["-vv", "read", "--port", port, "--json"]).err.splitlines()
    sent = [line for line in lines if " > 42 61 " in line]
    assert [bytes.fromhex(line.split(" > ")[1][:17]) for line in sent] == wire
    assert sum(" < 41 75 " in line for line in lines) == len(wire)
    assert any("status: tilt 0°" in line for line in lines)


def test_control_characters_are_shown_and_not_obeyed(capsys: pytest.CaptureFixture[str]) -> None:
    console.write_lines([ESCAPE, (ESCAPE, 31)])
    console.notify(ESCAPE)
    printed = capsys.readouterr()
    assert (printed.out + printed.err).replace("\n", "").isprintable()
    shown = visible(f"a{ESCAPE}\ud800\r\tb\n", keep="\n")
    assert shown == ("a[U+001B]]0;owned[U+0007][U+009B]31m[U+202E][U+2066][U+D800]  b\n")
    assert visible("M-07 伞仓 3.8 V …") == "M-07 伞仓 3.8 V …"
    text = console.as_json({ESCAPE: ESCAPE})
    assert text.isprintable()
    assert json.loads(text) == {ESCAPE: ESCAPE}


@pytest.mark.parametrize(
    "words",
    [
        ["decode", ESCAPE],
        ["read", "--port", f"spy://{ESCAPE}"],
        ["read", "--port", "loop://", "--baud", ESCAPE],
        ["set", f"freefall_time_s={ESCAPE}", "--port", "loop://"],
        ["preflight", "--port", "loop://", "--profile", f"/{ESCAPE}.toml"],
        ["verify", f"/{ESCAPE}"],
        ["simulate", f"--{ESCAPE}"],
        ["recordings", "export", ESCAPE, f"/nowhere/{ESCAPE}.csv"],
        [ESCAPE],
    ],
    ids=lambda words: words[0] if words[0].isprintable() else "no command",
)
@pytest.mark.promise("g")
def test_no_command_prints_typed_control_characters(words: list[str], dps_s: Program) -> None:
    printed = dps_s(words, 2)
    both = (printed.out + printed.err).replace("\n", "")
    assert both
    assert both.isprintable(), both


# Signals


posix_signals = pytest.mark.skipif(sys.platform == "win32", reason="os.kill would end the process")


@posix_signals
def test_a_pipe_that_nobody_reads_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    reading, writing = os.pipe()
    with open(writing, "w", encoding="utf-8") as out:  # noqa: PTH123
        monkeypatch.setattr(sys, "stdout", out)
        with console.signals_noted():
            threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT)).start()
            with pytest.raises(KeyboardInterrupt):
                console.write("x" * 2_000_000)  # more than a pipe holds
        monkeypatch.undo()
    os.close(reading)


@posix_signals
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


@posix_signals
@pytest.mark.parametrize("words", [["set", "freefall_time_s=1.4"], ["activate", "--yes"]])
def test_a_signal_before_the_port_is_opened_keeps_everything_from_being_sent(
    words: list[str], port: str, dps_s: Program, monkeypatch: pytest.MonkeyPatch, wire: list[bytes]
) -> None:
    def interrupted_start(store: Store) -> None:
        os.kill(os.getpid(), signal.SIGTERM)
        start(store)

    start = Store.start
    monkeypatch.setattr(Store, "start", interrupted_start)
    dps_s([*words, "--port", port], 128 + signal.SIGTERM)
    assert wire == []


# Files


@pytest.mark.promise("g")
def test_nothing_is_written_through_the_link_of_another_user(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    victim, link = tmp_path / "victim", tmp_path / "link"
    victim.write_text("mine", encoding="utf-8")
    link.symlink_to(victim)
    write_whole(link, b"mine, too")
    assert victim.read_text(encoding="utf-8") == "mine, too"
    assert link.is_symlink()
    monkeypatch.setattr(os, "geteuid", lambda: link.lstat().st_uid + 1)
    write_whole(link, b"theirs")
    assert victim.read_text(encoding="utf-8") == "mine, too"
