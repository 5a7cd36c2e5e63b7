"""Faults around the window: it stays responsive, reports them in a sentence, and continues; nothing grows with any
event.
"""

import gc
import logging
import sys
from collections import Counter, deque
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from unittest.mock import patch

import pytest
from PySide6.QtCore import QEvent, QObject
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.session import Session
from app.engine.target import Target
from app.safety.journal import Act
from app.system.uncaught import catch_uncaught_errors
from tests.support.window.fake_ports import VALUES, FakePorts, FakeWorker, fake_window
from tests.support.window.fakes_ui import ADAPTER, connect, simulated, window
from tests.support.window.steps import find, notice_text
from ui.main import PAGES, Assembly
from ui.pages.live.page import LivePage

POSIX_ONLY = pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")


def notice_of(assembly: Assembly) -> str:
    return notice_text(assembly.window.notice_bar)


@POSIX_ONLY
def test_an_error_in_the_worker_closes_the_port_and_is_shown(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_session: Session, _longest_s: float) -> None:
        monkeypatch.undo()
        raise KeyError("bug")

    with simulated("struck"), window(qapp, tmp_path) as assembly, ExitStack() as stack:
        stack.callback(catch_uncaught_errors(assembly.window.attention.report))
        connect(qtbot, assembly, "sim://struck")
        assembly.armed.act = Act.ZERO
        monkeypatch.setattr(Session, "step", fail)
        qtbot.waitUntil(lambda: "KeyError: 'bug'" in notice_of(assembly))
        assert assembly.window.notice_bar.button("copy_details") is not None
        assert not assembly.ports.current.is_open
        assert assembly.armed.act is None
        connect(qtbot, assembly, "sim://struck")


TIMES = 8
BOUNDED = ("Marker", "Mark", "StepPoint", "ReferenceType")
"""Kept in bounded queues, for the time line; `sqlite3.Connection` keeps up to 200 weak references to
its cursors."""
PACKAGES = ("app", "protocol", "ui")


@contextmanager
def connected(qtbot: QtBot, qapp: QApplication, folder: Path) -> Iterator[tuple[Assembly, FakeWorker, FakePorts]]:
    """The window with all pages on a port that the test unplugs."""
    logging.disable()  # pytest keeps the records of a test
    try:
        with (
            patch("ui.session.port.FOLLOW_EVERY_MS", 0),
            fake_window(qapp, folder, ADAPTER) as (fakes, assembly),
        ):
            qtbot.waitUntil(lambda: assembly.window.has_pages)
            assembly.ports.connect_to(Target(ADAPTER.device, 115200, ADAPTER.identity))
            worker = fakes.workers[-1]
            worker.say(**VALUES)
            yield assembly, worker, fakes
    finally:
        logging.disable(logging.NOTSET)


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


def test_no_object_stays_behind(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with connected(qtbot, qapp, tmp_path) as (assembly, worker, fakes):
        window, connector = assembly.window, assembly.ports

        def unplug() -> None:
            opened = len(worker.opened)
            worker.unplug()
            fakes.now_s += 1.0
            qtbot.waitUntil(lambda: len(worker.opened) > opened)
            worker.hand_over()
            QApplication.processEvents()
            worker.say(**VALUES)
            fakes.now_s += 1.0
            qtbot.waitUntil(lambda: connector.current.is_open)
            QApplication.processEvents()

        def visit() -> None:
            for page in PAGES:
                window.go_to(page.key)
                QApplication.processEvents()

        def lock() -> None:
            assembly.ports.lock.press()
            worker.end_jobs()
            QApplication.processEvents()

        def again(act: Callable[[], None], times: int = TIMES) -> Counter[str]:
            for _ in range(times):
                act()
            worker.jobs.clear()  # it remembers all
            find(window, LivePage).draw()  # it has kept what came since it last drew
            return census(window)

        for act in (unplug, visit, lock):
            first, second, third = again(act, times=2), again(act), again(act)
            grown = (second - first) & (third - second)  # not what is made once, the first time
            stayed = {name: count for name, count in grown.items() if count >= TIMES and name not in BOUNDED}
            assert not stayed, act.__name__
