"""Nothing in the window grows with each unplugged and returned port, visited page or changed language."""

import gc
import logging
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from tests.support.window.fake_ports import VALUES, FakePorts, FakeWorker
from tests.support.window.fakes_ui import ADAPTER, Ports
from ui.core.connector import Connector
from ui.core.port_watcher import PortWatcher
from ui.core.preferences import Preferences
from ui.main import PAGES, Assembly, WindowOptions, assemble
from ui.services.storage import Storage

LIMIT_MS = 60_000
TIMES = 8
BOUNDED = ("Marker", "Mark", "StepPoint", "Slice", "ReferenceType")
"""Kept in bounded queues for the time line; `sqlite3.Connection` keeps up to 200 weak references to its cursors."""


@contextmanager
def connected(qtbot: QtBot, qapp: QApplication, folder: Path) -> Iterator[tuple[Assembly, FakeWorker, FakePorts]]:
    """The window with all pages on a port that the test unplugs."""
    fakes, storage = FakePorts(), Storage(folder / "store")

    def made(ports: PortWatcher, **_: object) -> Connector:
        return Connector(ports, make_worker=fakes.make, clock=lambda: fakes.now_s)

    with (
        patch("ui.main.Connector", made),
        patch("ui.core.port_connection.FOLLOW_EVERY_MS", 0),
    ):
        assembly = assemble(
            qapp,
            WindowOptions(language="en"),
            preferences=Preferences(folder / "window.ini"),
            ports=PortWatcher(Ports(ADAPTER).poll),
            storage=storage,
        )
        window = assembly.window
        logging.disable()  # pytest keeps the records of a test
        try:
            window.make_pages()
            window.show()
            qtbot.waitUntil(lambda: window.findChild(QObject, "diagnosis_page") is not None, timeout=LIMIT_MS)
            assembly.connector.connect_to(Target(ADAPTER.device, 115200, ADAPTER.identity))
            worker = fakes.workers[-1]
            worker.say(**VALUES)
            yield assembly, worker, fakes
        finally:
            logging.disable(logging.NOTSET)
            window.close_now()
            assembly.connector.stop(2.0)
            assembly.ports.stop(2.0)
            storage.close()
            assembly.language_switch.use("en")
            window.deleteLater()
            QApplication.processEvents()


def census(root: QObject) -> Counter[str]:
    """How many objects there are of each type: Python's, and Qt's below `root`."""
    QApplication.processEvents()
    gc.collect()
    counts = Counter(type(one).__qualname__ for one in gc.get_objects())
    counts.update(f"Qt {one.metaObject().className()}" for one in root.findChildren(QObject))
    return counts


def test_no_object_stays_behind(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with connected(qtbot, qapp, tmp_path) as (assembly, worker, fakes):
        window, connector = assembly.window, assembly.connector

        def unplug() -> None:
            opened = len(worker.opened)
            worker.unplug()
            fakes.now_s += 1.0
            qtbot.waitUntil(lambda: len(worker.opened) > opened, timeout=LIMIT_MS)
            worker.say(**VALUES)
            fakes.now_s += 1.0
            qtbot.waitUntil(lambda: connector.is_open, timeout=LIMIT_MS)
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
            assembly.lock.press()
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
            stayed = {name: count for name, count in grown.items() if count >= TIMES and name not in BOUNDED}
            assert not stayed, act.__name__
