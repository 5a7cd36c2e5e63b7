"""Faults around the window: it stays responsive, reports them in a sentence, and continues."""

import errno
import itertools
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
import serial
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.diagnosis.link_state import Phase
from app.engine.session import Session
from app.engine.target import Target
from app.engine.worker import Job
from app.procedures.act import Performed, perform
from app.safety.acts import REQUESTS, Act
from app.safety.interlocks import Interlock
from app.safety.journal import Outcome
from app.safety.permit import Origin, Permit
from app.store.database import StoreTrouble
from app.store.store import Store
from app.system.logs import start_log
from tests.support.patience import PATIENCE_S
from tests.support.processes import ENVIRONMENT, PROGRAM, ROOT, run_module
from tests.support.window.fakes_ui import ADAPTER, ListedPorts, connect, simulated, wait_online, window
from ui.main import Assembly, _errors_shown

BEAT_MS = 10
LONGEST_STALL_S = 5.0
"""A list of ten seconds would show, a busy machine does not."""
POSIX_ONLY = pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")


def notice_of(assembly: Assembly) -> str:
    notice = assembly.window.notice_bar.notice
    return "" if notice is None else notice.text


def test_a_blocked_list_of_ports_blocks_nothing_else(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    ports, beats = ListedPorts(ADAPTER), list[float]()
    ports.hold()
    timer = QTimer()
    timer.setInterval(BEAT_MS)
    timer.timeout.connect(lambda: beats.append(time.monotonic()))
    with simulated("patient"), window(qapp, tmp_path, ports=ports) as assembly:
        qtbot.waitUntil(lambda: ports.looks == 1)
        timer.start()
        assembly.window.go_to("traffic")
        connect(qtbot, assembly, "sim://patient")
        qtbot.waitUntil(lambda: len(beats) > 50)
        timer.stop()
        assert not assembly.ports.has_listed
        assert ports.looks == 1
        ports.release()
        qtbot.waitUntil(lambda: assembly.ports.has_listed)
    assert max(after - before for before, after in itertools.pairwise(beats)) < LONGEST_STALL_S


@POSIX_ONLY
def test_a_port_in_use_names_the_process(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with run_module("--uptime", "60") as module:
        command = [*PROGRAM, "monitor", "--port", module.port, "--seconds", "60", "--json"]
        with subprocess.Popen(command, cwd=ROOT, env=ENVIRONMENT, text=True, stdout=subprocess.PIPE) as first:
            try:
                assert first.stdout is not None
                assert first.stdout.readline()  # it works
                with window(qapp, tmp_path) as assembly:
                    assembly.connector.connect_to(Target(module.port, 115200))
                    qtbot.waitUntil(lambda: assembly.connector.current.state.phase is Phase.FAILED)
                    qtbot.waitUntil(lambda: "in use by" in notice_of(assembly))
                    if sys.platform.startswith("linux"):
                        holders = (first.pid, module.process.pid)  # the simulated module has it open too
                        assert any(f"(process {pid})" in notice_of(assembly) for pid in holders)
                    first.terminate()
                    first.communicate(timeout=PATIENCE_S)
                    assembly.window._connect_again()
                    wait_online(qtbot, assembly)
            finally:
                with suppress(ProcessLookupError):
                    first.kill()


@POSIX_ONLY
def test_a_port_without_permission(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_serial: serial.Serial) -> None:
        raise serial.SerialException(errno.EACCES, f"could not open port: {os.strerror(errno.EACCES)}")

    monkeypatch.setattr(serial.Serial, "open", refuse)
    with window(qapp, tmp_path) as assembly:
        assembly.connector.connect_to(Target("/dev/ttyS0", 115200))
        qtbot.waitUntil(lambda: "/dev/ttyS0" in notice_of(assembly))
        assert assembly.connector.current.state.phase is Phase.FAILED


def fill(store: Store) -> None:
    """As on a full disk: not one page more."""
    with store.database.transaction():  # of the connection that writes
        store.database.read("PRAGMA max_page_count = 1")
    for size in (4000, 400, 40, 0):
        with suppress(StoreTrouble):
            while True:
                store.begin(Act.ZERO, REQUESTS[Act.ZERO].encode(), {"much": "x" * size}, port="p", origin="window")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_refuses_dangerous_acts_only(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    (tmp_path / "log").mkdir()
    (tmp_path / "log" / "dps-s.log").symlink_to("/dev/full")
    log = start_log(tmp_path / "log")
    try:
        with simulated("full", active=True) as bench, window(qapp, tmp_path) as assembly:
            store = assembly.storage.store
            assert isinstance(store, Store)
            fill(store)
            target = Target("sim://full", 115200)
            assembly.connector.connect_to(target)
            wait_online(qtbot, assembly)
            assert log.trouble is not None
            assembly.window.top_bar.lock.click()  # always safe, so never refused
            qtbot.waitUntil(lambda: not bench.state().is_active)
            wait_online(qtbot, assembly)
            ended: list[Job[Performed]] = []
            permit = Permit(Act.ZERO, Origin.CONFIRMATION, assembly.connector.clock())
            assembly.connector.run(perform(Act.ZERO, assembly.storage.journal(target), permit=permit), ended.append)
            qtbot.waitUntil(lambda: bool(ended))
            performed = ended[0].outcome()
            assert performed.outcome is Outcome.NOT_SENT
            assert Interlock.INTENT_DURABLE in {refusal.condition for refusal in performed.refusals}
            assert "disk is full" in performed.sentence
            assert assembly.connector.current.state.phase is Phase.ONLINE
    finally:
        log.stop()


@POSIX_ONLY
def test_an_error_in_the_worker_closes_the_port_and_is_shown(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_session: Session, _longest_s: float) -> None:
        monkeypatch.undo()
        raise KeyError("bug")

    with simulated("struck"), window(qapp, tmp_path) as assembly, _errors_shown(assembly.window, assembly.armed):
        connect(qtbot, assembly, "sim://struck")
        assembly.armed.act = Act.ZERO
        monkeypatch.setattr(Session, "step", fail)
        qtbot.waitUntil(lambda: "KeyError: 'bug'" in notice_of(assembly))
        assert assembly.window.notice_bar.button("copy_details") is not None
        assert not assembly.connector.current.is_open
        assert assembly.armed.act is None
        connect(qtbot, assembly, "sim://struck")


@POSIX_ONLY
def test_killed_and_started_again(tmp_path: Path) -> None:
    """kill -9 leaves a port that can be opened, a store that can be read, and no word of it to the next one."""
    code = """if True:
        import sys
        from ui import main as application
        def told(assembly, options, start=application.start):
            assembly.connector.came_online.connect(lambda _target: print("online", flush=True))
            start(assembly, options)
        application.start = told
        raise SystemExit(application.run(application.WindowOptions(port=sys.argv[1])))
    """
    environment = {**ENVIRONMENT, "QT_QPA_PLATFORM": "offscreen", "HOME": str(tmp_path)}
    with run_module("--uptime", "60", "--rate", "200") as module:
        for end, code_expected in ((signal.SIGKILL, -signal.SIGKILL), (signal.SIGTERM, 0)):
            with subprocess.Popen(
                [sys.executable, "-B", "-c", code, module.port],
                cwd=ROOT, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            ) as program:  # fmt: skip
                try:
                    assert program.stdout is not None
                    assert program.stdout.readline() == "online\n"
                    program.send_signal(end)
                    _, said = program.communicate(timeout=PATIENCE_S)
                finally:
                    with suppress(ProcessLookupError):
                        program.kill()
            assert program.returncode == code_expected
            assert [line for line in said.splitlines() if "propagateSizeHints" not in line] == []


@POSIX_ONLY
def test_what_a_killed_window_left_active_stands_first_at_the_next_start(tmp_path: Path) -> None:
    code = """if True:
        import sys
        from PySide6.QtCore import QTimer
        from ui import main as application
        def watched(assembly, options, start=application.start):
            def look():
                notice = assembly.window.notice_bar.notice
                if assembly.storage.left_active and (options.port or notice is not None and "ACTIVE" in notice.text):
                    timer.stop()
                    print("kept" if options.port else notice.text, flush=True)
            timer = QTimer(assembly.window, interval=50, timeout=look)
            timer.start()
            start(assembly, options)
        application.start = watched
        raise SystemExit(application.run(application.WindowOptions(port=sys.argv[1] or None)))
    """
    environment = {**ENVIRONMENT, "QT_QPA_PLATFORM": "offscreen", "HOME": str(tmp_path)}
    with run_module("--active", "yes") as module:
        for port, said in ((module.port, "kept"), ("", f"The module at {module.port} was left ACTIVE on ")):
            with subprocess.Popen(
                [sys.executable, "-B", "-c", code, port], cwd=ROOT, env=environment, text=True, stdout=subprocess.PIPE
            ) as program:
                try:
                    assert program.stdout is not None
                    assert program.stdout.readline().startswith(said)
                finally:
                    program.kill()


def test_a_trouble_that_returns_is_dismissed_once(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path) as assembly:
        shown = assembly.window
        qtbot.waitSignal(shown.pages_made).wait()
        shown.panel.hide()
        for _ in range(3):
            shown.recording_sign.troubled.emit()
            assembly.connector.stream_left_on.emit()
        qtbot.waitUntil(lambda: shown.notice_bar.notice is not None)
        for _ in range(2):
            notice = shown.notice_bar.notice
            assert notice is not None
            assert notice.dismiss is not None
            notice.dismiss()
        left = shown.notice_bar.notice
        assert left is not None
        assert [choice.key for choice in left.choices] == ["choose_port"], "that of the link"
