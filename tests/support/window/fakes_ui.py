"""Opens windows for tests, with fake lists of ports and without saved preferences."""

from collections.abc import Iterator
from concurrent.futures import wait
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from PySide6.QtCore import QTranslator
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.ports import PortInfo
from app.engine.target import Target
from app.simulator import bench
from app.simulator.bench import SimulatedBench
from app.simulator.setup import Setup
from app.store.fact_store import Store
from app.text.i18n import ENGLISH, language
from tests.support.patience import PATIENCE_S
from ui.core.port_watcher import PortWatcher
from ui.core.preferences import Preferences, use_language
from ui.main import PAGES, Assembly, WindowOptions, assemble, start
from ui.services.context import PageEntry
from ui.services.page import Page
from ui.services.storage import Storage
from ui.style.icons import Icon

ADAPTER = PortInfo("/dev/ttyUSB0", "CP2102 USB to UART", "Silicon Labs", "0001", 0x10C4, 0xEA60, "1-1")
SECOND_ADAPTER = PortInfo("/dev/ttyACM0", "USB Single Serial", "QinHeng", "5523", 0x1A86, 0x55D3, "1-2")


EMPTY_PAGE = (PageEntry("empty", "Traffic", Icon.DIAGNOSIS, lambda _services: Page("empty")),)
"""For tests of the window around the pages: what a page paints of each batch takes longer than all else."""


def page_entries(*keys: str) -> tuple[PageEntry, ...]:
    """The entries of these pages: making all of them takes seconds."""
    return tuple(entry for entry in PAGES if entry.key in keys)


class ListedPorts:
    """A list of ports in place of the system's."""

    def __init__(self, *ports: PortInfo) -> None:
        self.now: list[PortInfo] = list(ports)
        self.looks = 0

    def poll(self, deadline_s: float) -> list[PortInfo]:
        self.looks += 1
        return list(self.now)


@contextmanager
def window(
    qapp: QApplication,
    folder: Path,
    *,
    listed: ListedPorts | None = None,
    options: WindowOptions | None = None,
    entries: tuple[PageEntry, ...] = EMPTY_PAGE,
) -> Iterator[Assembly]:
    """Show a window in the language in use; close it and stop its threads afterwards."""
    options = options or WindowOptions(language=language())
    assembly = assemble(
        qapp,
        options,
        preferences=Preferences(folder / "window.ini"),
        watcher=PortWatcher((listed or ListedPorts()).poll),
        entries=entries,
    )
    try:
        assembly.storage.open_store()  # so that a test finds it as after a moment
        start(assembly, options)
        yield assembly
    finally:
        assembly.window.close_now()
        assembly.ports.stop(2.0)
        assembly.watcher.stop(2.0)
        assembly.storage.close()
        if language() != ENGLISH:
            use_language(qapp, ENGLISH)
            for qt_texts in qapp.findChildren(QTranslator):
                qapp.removeTranslator(qt_texts)
        assembly.window.deleteLater()
        QApplication.processEvents()


def store_of(storage: Storage) -> Store:
    """That of a folder which can be written."""
    store = storage.open_store()
    assert isinstance(store, Store)
    return store


def wait_for_disk(assembly: Assembly) -> None:
    """Wait for what the store is still asked to write."""
    store = assembly.storage.store
    if isinstance(store, Store):
        wait([store.write(lambda _facts: None)], PATIENCE_S)


@contextmanager
def simulated(name: str, **options: Any) -> Iterator[SimulatedBench]:
    """Make the simulated module of this name with these options; discard it afterwards."""
    bench.remove_bench(name)  # a window that outlived another one of this name has opened it again
    try:
        yield bench.module(name, Setup(**{"rate": 20} | options))  # more takes time, and shows nothing else
    finally:
        bench.remove_bench(name)


def wait_online(qtbot: QtBot, assembly: Assembly) -> None:
    """Wait until the module answers and its status is known."""

    def is_known() -> bool:
        module = assembly.ports.module
        return module.is_going and module.view.known("active", module.now_s) is not None

    qtbot.waitUntil(is_known)


def connect(qtbot: QtBot, assembly: Assembly, port: str) -> None:
    """Connect to this port, and wait until its module answers."""
    assembly.ports.connect_to(Target(port, 115200))
    wait_online(qtbot, assembly)
