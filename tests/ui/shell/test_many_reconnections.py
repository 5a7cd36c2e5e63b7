"""Nothing in the window grows with each unplugged and returned port, visited page or changed language."""

import gc
import logging
from collections import Counter, deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from tests.support.window.fake_ports import VALUES, FakePorts, FakeWorker
from tests.support.window.fakes_ui import ADAPTER, ListedPorts, close_window
from ui.core.port_watcher import PortWatcher
from ui.core.preferences import Preferences
from ui.main import PAGES, Assembly, WindowOptions, assemble, start
from ui.services.port import Ports
from ui.services.storage import Storage

TIMES = 8
BOUNDED = ("Marker", "Mark", "StepPoint", "Slice", "ReferenceType")
"""Kept in bounded queues, for the time line and the statistics; `sqlite3.Connection` keeps up to 200 weak references to
its cursors."""
OF_A_SLICE = {"Counters": 1, "Counter": 2}
"""The counts that each second of the statistics holds."""
PACKAGES = ("app", "protocol", "ui")


@contextmanager
def connected(qtbot: QtBot, qapp: QApplication, folder: Path) -> Iterator[tuple[Assembly, FakeWorker, FakePorts]]:
    """The window with all pages on a port that the test unplugs."""
    fakes, storage = FakePorts(), Storage(folder / "store")

    def made(ports: PortWatcher, _storage: Storage) -> Ports:
        return Ports(ports, storage, make_worker=fakes.make, clock=lambda: fakes.now_s)

    with (
        patch("ui.main.Ports", made),
        patch("ui.core.port_connection.FOLLOW_EVERY_MS", 0),
    ):
        options = WindowOptions(language="en")
        assembly = assemble(
            qapp,
            options,
            preferences=Preferences(folder / "window.ini"),
            ports=PortWatcher(ListedPorts(ADAPTER).poll),
            storage=storage,
        )
        window = assembly.window
        logging.disable()  # pytest keeps the records of a test
        try:
            start(assembly, options)
            qtbot.waitUntil(lambda: window.findChild(QObject, "diagnosis_page") is not None)
            assembly.connector.connect_to(Target(ADAPTER.device, 115200, ADAPTER.identity))
            worker = fakes.workers[-1]
            worker.say(**VALUES)
            yield assembly, worker, fakes
        finally:
            logging.disable(logging.NOTSET)
            close_window(assembly)


def census(root: QObject) -> Counter[str]:
    """How many objects there are of each type: Python's, and Qt's below `root`; and how many entries the containers in
    each attribute of the program's own objects have."""
    QApplication.processEvents()
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
        window, connector = assembly.window, assembly.connector

        def unplug() -> None:
            opened = len(worker.opened)
            worker.unplug()
            fakes.now_s += 1.0
            qtbot.waitUntil(lambda: len(worker.opened) > opened)
            worker.hand_over()
            QApplication.processEvents()
            connector.current.stream_memory.is_taken_over = True  # the module still streams
            worker.say(**VALUES)
            fakes.now_s += 1.0
            qtbot.waitUntil(lambda: connector.current.is_open)
            QApplication.processEvents()

        def visit() -> None:
            for page in PAGES:
                window.go_to(page.key)
                QApplication.processEvents()

        def speak() -> None:
            for language in ("zh_CN", "en"):
                assembly.language_switch.use(language)
                QApplication.processEvents()

        def lock() -> None:
            assembly.connector.lock.press()
            worker.end_jobs()
            QApplication.processEvents()

        def again(act: Callable[[], None]) -> Counter[str]:
            for _ in range(TIMES):
                act()
            worker.jobs.clear()  # it remembers all
            return census(window)

        for act in (unplug, visit, speak, lock):
            first, second, third = again(act), again(act), again(act)
            grown = (second - first) & (third - second)  # not what is made once, the first time
            grown.subtract({name: count * grown["Slice"] for name, count in OF_A_SLICE.items()})
            stayed = {name: count for name, count in grown.items() if count >= TIMES and name not in BOUNDED}
            assert not stayed, act.__name__
