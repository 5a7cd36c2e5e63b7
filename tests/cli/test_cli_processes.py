"""`dps-s` as a user meets it: a process of its own, on the pseudo-terminal of a simulated module in another process."""

import csv
import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import IO

import pytest

from app.captures.traffic import Way
from app.recordings.library import RecordingLibrary
from tests.support.patience import PATIENCE_S, in_time
from tests.support.processes import PROGRAM, Running, RunningModule, ran, ran_code, run_module, running
from tests.support.records.recordings_made import read_session

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals on Windows")

STRICT = {"LC_ALL": "C.UTF-8", "PYTHONWARNINGS": "error"}


@pytest.fixture(scope="module")
def module() -> Iterator[RunningModule]:
    """One module for all tests that leave it as it was."""
    with run_module("--rate", "200", "--history", "2") as one:
        yield one


def dps_s(*words: str) -> "subprocess.CompletedProcess[str]":
    return ran(*PROGRAM, *words, **STRICT)


def started(*words: str) -> AbstractContextManager[Running]:
    return running(*PROGRAM, *words, **STRICT)


def lines_until(out: IO[str], t_s: float) -> list[str]:
    """The lines of `monitor --json` up to the first of that time."""
    lines = []
    for line in out:
        lines.append(line)
        if json.loads(line)["t_s"] >= t_s:
            break
    return lines


def is_quiet(port: str, for_s: float = 0.25) -> bool:
    """Whether nothing is streamed."""
    number = os.open(port, os.O_RDWR | os.O_NOCTTY)
    try:
        while select.select([number], [], [], 0)[0]:
            os.read(number, 65536)
        return not select.select([number], [], [], for_s)[0]
    finally:
        os.close(number)


def unexpected(errors: str) -> list[str]:
    """Where others keep the machine busy for half a second a conversation ends, which is said."""
    return [line for line in errors.splitlines() if not line.endswith("Another module may answer from now on.")]


def assert_one_sentence(text: str) -> None:
    assert text.count("\n") == 1, text
    assert text.endswith(".\n")
    assert "Traceback" not in text


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.promise("c")
def test_monitor_interrupted_leaves_the_module_silent(number: int, module: RunningModule) -> None:
    with started("monitor", "--port", module.port, "--json") as monitor:
        lines = lines_until(monitor.out, 2.9)
        with in_time(2.0):
            monitor.process.send_signal(number)
            code, rest, errors = monitor.end()
    assert (code, unexpected(errors)) == (0, [])
    assert [json.loads(line)["tilt_deg"] for line in (*lines, *rest.splitlines())][-1] == 0
    assert len(lines) > 20, "it did not stream"
    assert is_quiet(module.port)


@pytest.mark.usefixtures("user_files")
@pytest.mark.parametrize("name", ["a.csv", "a.mcap"])
def test_record_interrupted_leaves_file_and_recording_whole(name: str, module: RunningModule, tmp_path: Path) -> None:
    path, library = tmp_path / name, RecordingLibrary()
    with started("record", "--port", module.port, str(path)) as record:
        deadline = time.monotonic() + PATIENCE_S
        while not (library.entries() and library.entries()[0].sample_count > 100) and time.monotonic() < deadline:
            select.select([], [], [], 0.1)
        record.process.send_signal(signal.SIGINT)
        code, printed, errors = record.end()
    assert (code, unexpected(errors)) == (0, [])
    assert "Saved to" in printed
    (entry,) = library.entries()
    assert entry.trouble is None
    assert not entry.is_running
    assert not entry.was_cut_off
    if name.endswith(".csv"):
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = list(csv.DictReader(file))
        assert sum(bool(row["tilt_deg"]) for row in rows) == entry.sample_count > 100
    else:
        received = b"".join(one.raw for one in read_session(path) if one.way is Way.IN)
        assert received.count(b"Au2") >= entry.sample_count > 100
    assert is_quiet(module.port)


def test_monitor_into_head(module: RunningModule) -> None:
    """Whoever reads goes away while it streams: quiet, and the stream off."""
    with started("monitor", "--port", module.port, "--json") as monitor:
        lines_until(monitor.out, 2.9)
        monitor.out.close()
        assert monitor.process.wait(PATIENCE_S) == 4
        assert unexpected(monitor.errors.read()) == []
    assert is_quiet(module.port)


def test_monitor_stuck_in_a_full_pipe_can_be_ended() -> None:
    """Nobody reads, so it cannot even print: the signal still ends it, and the stream."""
    with run_module("--rate", "1440") as module, started("monitor", "--port", module.port, "--json") as monitor:
        lines_until(monitor.out, 1.2)
        # A pipe holds 64 KiB, which is half a second of the stream.
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline and not is_blocked_in_writing(monitor.process.pid):
            select.select([], [], [], 0.05)
        with in_time(2.0):
            monitor.process.send_signal(signal.SIGTERM)
            monitor.process.wait(PATIENCE_S)
        assert unexpected(monitor.errors.read()) == []
        assert is_quiet(module.port)


def is_blocked_in_writing(pid: int) -> bool:
    """Where the system tells (Linux); elsewhere what follows is merely an ordinary interruption."""
    try:
        return "pipe_write" in Path(f"/proc/{pid}/wchan").read_text(encoding="ascii")
    except OSError:
        return True


def test_unplugged_while_monitoring() -> None:
    with run_module() as module, started("monitor", "--port", module.port, "--json") as monitor:
        lines = lines_until(monitor.out, 0.3)
        module.process.kill()  # its pseudo-terminal goes with it
        code, rest, errors = monitor.end()
    assert code == 3
    assert len(lines) > 1
    assert all(json.loads(line)["acceleration_g"] == 1.0 for line in (*lines, *rest.splitlines()))
    assert_one_sentence(errors)
    assert f"{module.port} was unplugged" in errors


def test_find_is_interrupted_like_any_program() -> None:
    """No result, so 130; and within the time that a person waits for Ctrl-C."""
    master, slave = os.openpty()
    try:
        with started("find", "--port", os.ttyname(slave)) as find:
            assert select.select([master], [], [], PATIENCE_S)[0], "nothing was sent"
            find.process.send_signal(signal.SIGINT)
            with in_time(0.5):
                ended = find.end()
    finally:
        os.close(master)
        os.close(slave)
    assert ended == (130, "", "")


def redirected(how: str, *words: str) -> "subprocess.CompletedProcess[str]":
    """With its streams as a shell has them; what is printed leaves at its end only."""
    unbuffered = STRICT | {"PYTHONUNBUFFERED": ""}
    return ran("sh", "-c", f'exec "$@" {how}', "sh", *PROGRAM, *words, **unbuffered)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="only Linux has a device that is always full")
def test_a_full_disk_is_said() -> None:
    run = redirected(">/dev/full", "ports", "--json")
    assert run.returncode == 4
    assert_one_sentence(run.stderr)


def test_messages_do_not_go_to_the_output_where_theirs_is_closed() -> None:
    run = redirected("2>&-", "find", "--port", "/dev/no-such-port", "--json")
    assert run.returncode == 3
    assert json.loads(run.stdout)["error"]["code"] == "no_port"


def test_help_and_decode_need_no_serial_port() -> None:
    code = (
        "import sys, app.__main__ as program\n"
        "codes = program.main(sys.argv[1:])\n"
        "heavy = {'serial', 'numpy', 'PySide6', 'app.engine.worker'} & set(sys.modules)\n"
        "sys.exit(f'{codes} {heavy}' if codes or heavy else 0)"
    )
    for words in (["--help"], ["--version"], ["decode", "41", "75", "32", "07", "0A", "00", "01", "44"]):
        run = ran_code(code, *words, **STRICT)
        assert (run.returncode, run.stderr) == (0, ""), words


def test_reading_loads_nothing_that_it_does_not_use() -> None:
    code = (
        "import sys; before = set(sys.modules); import app.__main__ as program\n"
        "code = program.main(sys.argv[1:])\n"
        "unused = {'importlib.metadata', 'email', 'zipfile', 'hashlib', 'xml', 'logging.handlers', 'json'}\n"
        "unused |= {'sqlite3', 'concurrent.futures', 'numpy', 'PySide6', 'cryptography', 'dataclasses'}\n"
        "unused = unused & set(sys.modules) - before\n"
        "sys.exit(f'{code} {unused}' if code or unused else 0)"
    )
    with run_module() as module:
        run = ran_code(code, "read", "--port", module.port, **STRICT)
    assert (run.returncode, run.stderr) == (0, "")
