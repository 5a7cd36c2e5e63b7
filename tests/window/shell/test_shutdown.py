"""Closing takes at most half a second, whatever the driver, the module and the disk do; faults are said in a sentence,
and nothing grows with any event.
"""

import gc
import json
import logging
import threading
from collections import Counter, deque
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import serial
from PySide6.QtCore import QEvent, QObject
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.engine.session import Session
from app.engine.target import Target
from app.safety.journal import Act
from app.system.uncaught import uncaught_errors_told
from tests.support.patience import MACHINE_S, PATIENCE_S, in_time
from tests.support.processes import ran_code
from tests.support.window.fakes_ui import ADAPTER, ListedPorts, connect, simulated, window
from tests.support.window.rig import Rig, on_fake_time
from tests.support.window.steps import find, given, notice_text, press
from ui.core.preferences import Preferences
from ui.main import PAGES, Assembly
from ui.pages.diagnosis.page import DiagnosisPage
from ui.pages.live.page import LivePage
from ui.services.storage import Storage

CLOSING_S = 0.5
CALLS = ("open", "reset_input_buffer", "read", "write", "close")
_READ_S = 0.01


class StubbornPort:
    """Stands in for pyserial's port, and for what makes it. The call `sticks_in` blocks until `release`; no data ever
    arrives, and what cancels a call has no effect, as on a driver that hangs."""

    def __init__(self, sticks_in: str) -> None:
        self._sticks_in = sticks_in
        self._may_go_on = threading.Event()
        self.release = self._may_go_on.set
        # Set once the call blocks.
        self.is_stuck = threading.Event()
        self.baudrate, self.timeout, self.in_waiting = 115200, _READ_S, 0
        self.exclusive = self.dtr = self.rts = False

    def __call__(self, _port: str, **options: Any) -> "StubbornPort":
        self.baudrate = options["baudrate"]
        return self

    def __getattr__(self, name: str) -> Callable[..., Any]:
        if name not in (*CALLS, "reset_output_buffer", "cancel_read", "cancel_write"):
            raise AttributeError(name)
        return partial(self._call, name)

    def _call(self, name: str, *words: Any) -> Any:
        if name == self._sticks_in and not self._may_go_on.is_set():
            self.is_stuck.set()
            self._may_go_on.wait()
            raise serial.SerialException("the driver gave up")
        if name == "read":
            self._may_go_on.wait(0 if self._may_go_on.is_set() else self.timeout)
            return b""
        return len(words[0]) if name == "write" else None


@contextmanager
def stubborn(monkeypatch: pytest.MonkeyPatch, sticks_in: str) -> Iterator[StubbornPort]:
    port = StubbornPort(sticks_in)
    with monkeypatch.context() as patch:
        patch.setattr(serial, "serial_for_url", port)
        try:
            yield port
        finally:
            port.release()


@contextmanager
def held(monkeypatch: pytest.MonkeyPatch, owner: type, name: str) -> Iterator[threading.Event]:
    """A method that does not return before the end; the event is set once it was called."""
    is_over, was_called = threading.Event(), threading.Event()
    before = getattr(owner, name)

    def wait(*words: Any) -> Any:
        was_called.set()
        is_over.wait()
        return before(*words)

    with monkeypatch.context() as patch:
        patch.setattr(owner, name, wait)
        try:
            yield was_called
        finally:
            is_over.set()


def close_in_time(assembly: Assembly) -> None:
    with in_time(CLOSING_S):
        assembly.window.close_now()
    assert not assembly.window.isVisible()


@pytest.mark.parametrize("sticks_in", CALLS)
def test_a_driver_that_never_returns(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sticks_in: str
) -> None:
    with window(qapp, tmp_path) as assembly, stubborn(monkeypatch, sticks_in) as port:
        assembly.ports.connect_to(Target("/dev/stubborn", 115200))
        if sticks_in == "close":
            qtbot.waitUntil(lambda: assembly.ports.current.is_open)
        else:
            qtbot.waitUntil(port.is_stuck.is_set)
        close_in_time(assembly)
        assert port.is_stuck.wait(PATIENCE_S)


@pytest.mark.parametrize(
    ("owner", "name"), [(Storage, "close"), (Preferences, "save")], ids=["the store", "what is remembered"]
)
def test_a_disk_that_never_returns(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, owner: type, name: str
) -> None:
    with simulated("slow-disk"), window(qapp, tmp_path) as assembly, held(monkeypatch, owner, name) as was_called:
        connect(qtbot, assembly, "sim://slow-disk")
        close_in_time(assembly)
        assert was_called.is_set()


@pytest.mark.parametrize("sticks_in", ["write", "close", "store"])
def test_no_process_stays_behind(sticks_in: str) -> None:
    """The thread that the driver or the store holds does not keep the program alive; nothing is printed about it."""
    code = """if True:
        import functools, json, sys, time
        from tempfile import TemporaryDirectory
        from PySide6.QtCore import QTimer
        import serial
        from tests.window.shell.test_shutdown import StubbornPort
        from ui import main as application
        from ui.services.storage import Storage
        from ui.shell.main_window import MainWindow
        if sys.argv[1] == "store":
            close, remove = Storage.close, TemporaryDirectory.cleanup
            Storage.close = lambda storage: (time.sleep(1), close(storage))
            TemporaryDirectory.cleanup = lambda folder: (remove(folder), time.sleep(2))
        serial.serial_for_url = StubbornPort(sys.argv[1])
        application.assemble = functools.partial(application.assemble, entries=())
        end = MainWindow._end
        def timed(window):
            began = time.monotonic()
            end(window)
            print(json.dumps({"took_s": time.monotonic() - began}), flush=True)
        MainWindow._end = timed
        raise SystemExit(application.run(application.WindowOptions(port="/dev/stubborn", offscreen_seconds=2.5)))
    """
    ended = ran_code(code, sticks_in)
    # A slow machine may be told that the end of the recording is left to the system.
    usual = ("propagateSizeHints", "The recording was not closed within")
    said = [line for line in ended.stderr.splitlines() if not any(word in line for word in usual)]
    assert (ended.returncode, said) == (1, [])  # it was not seen that a module answers
    assert json.loads(ended.stdout.splitlines()[0])["took_s"] < CLOSING_S + MACHINE_S


@pytest.mark.promise("c")
def test_an_error_disarms_at_once_and_is_said_until_it_is_closed(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    """Also one of a thread that has nothing to do with a port, and again with the next error of its place."""
    with window(qapp, tmp_path) as assembly, ExitStack() as stack:
        bar, armed = assembly.window.notice_bar, assembly.armed
        stack.enter_context(uncaught_errors_told(assembly.window.attention.report))
        for _ in range(2):
            armed.act = Act.DEPLOY
            thread = threading.Thread(target=int, args=("no number",), name="falling")
            thread.start()
            thread.join()
            assert armed.act is None
            qtbot.waitUntil(lambda: "no number" in notice_text(bar))
            assert "Traceback" not in notice_text(bar)
            press(qtbot, find(bar, QWidget, "notice_dismiss"))
            qtbot.waitUntil(lambda: "no number" not in notice_text(bar))


def test_an_error_in_the_worker_closes_the_port_and_is_shown(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_session: Session) -> None:
        monkeypatch.undo()
        raise KeyError("bug")

    with simulated("struck"), window(qapp, tmp_path) as assembly, ExitStack() as stack:
        stack.enter_context(uncaught_errors_told(assembly.window.attention.report))
        connect(qtbot, assembly, "sim://struck")
        assembly.armed.act = Act.ZERO
        monkeypatch.setattr(Session, "step", fail)
        qtbot.waitUntil(lambda: "KeyError: 'bug'" in notice_text(assembly.window.notice_bar))
        press(qtbot, assembly.window.notice_bar.button("copy_details"))
        assert "Traceback" in QApplication.clipboard().text()
        assert not assembly.ports.current.is_open
        assert assembly.armed.act is None
        connect(qtbot, assembly, "sim://struck")


TIMES = 8
BOUNDED = ("Marker", "Mark", "StepPoint", "StatusSample", "ReferenceType")
"""Kept in bounded queues, for the time line, or for seconds; `sqlite3.Connection` keeps up to 200 weak references to
its cursors."""
PACKAGES = ("app", "protocol", "ui")


def census(root: QObject) -> Counter[str]:
    """How many objects there are of each type: Python's, and Qt's below `root`; and how many entries the containers in
    each attribute of the program's own objects have."""
    QApplication.processEvents()
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    gc.collect()
    everything = gc.get_objects()
    counts = Counter(type(one).__qualname__ for one in everything)
    counts.update(f"Qt {one.metaObject().className()}" for one in root.findChildren(QObject))
    for one in everything:
        if type(one).__module__.partition(".")[0] in PACKAGES:
            counts.update(entries_of(one))
    return counts


def entries_of(owner: object) -> dict[str, int]:
    """By attribute; without bounded queues. The same object can be in a list many times, so objects do not tell all."""
    slots = [name for kind in type(owner).__mro__ for name in getattr(kind, "__slots__", ())]
    values = {name: getattr(owner, name, None) for name in slots} | getattr(owner, "__dict__", {})
    return {
        f"{type(owner).__qualname__}.{name}": len(value)
        for name, value in values.items()
        if isinstance(value, list | dict | set | deque) and getattr(value, "maxlen", None) is None
    }


def test_no_object_stays_behind(
    request: pytest.FixtureRequest, qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    request.addfinalizer(partial(logging.disable, logging.NOTSET))
    logging.disable()  # pytest keeps the records of a test
    listed = ListedPorts(ADAPTER)
    with on_fake_time(Rig, qtbot, qapp, tmp_path, "unused", PAGES, listed) as one:
        window, (port, module) = one.window, one.plug_in(ADAPTER.device)

        def unplug() -> None:
            one.unplug(port)
            port.connect_to(given(port.target))
            one.until(lambda: port.module.is_read)

        def visit() -> None:
            for page in PAGES:
                window.go_to(page.key)
                QApplication.processEvents()

        def lock() -> None:
            one.assembly.ports.lock.press()
            one.until(lambda: not port.lock.is_unproven)

        def again(act: Callable[[], None], times: int = TIMES) -> Counter[str]:
            for _ in range(times):
                act()
            del one.lines[:-1]  # they remember all
            one.requests.clear()
            module.log.clear()
            find(window, DiagnosisPage).traffic.begin_again()
            live = find(window, LivePage)
            live.draw()  # it has kept what came since it last drew
            live.plot.draw(one.clock() + 61.0)  # and no mark is in sight
            return census(window)

        for act in (unplug, visit, lock):
            first, second, third = again(act, times=2), again(act), again(act)
            grown = (second - first) & (third - second)  # not what is made once, the first time
            stayed = {name: count for name, count in grown.items() if count >= TIMES and name not in BOUNDED}
            assert not stayed, act.__name__
