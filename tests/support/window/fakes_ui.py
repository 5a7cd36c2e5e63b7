"""What tests of the window share: ports that are not there, and a window that forgets everything."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from PySide6.QtWidgets import QApplication, QVBoxLayout
from pytestqt.qtbot import QtBot

from app.engine.ports import PortInfo
from app.engine.worker import Batch
from app.simulator import bench
from app.simulator.bench import SimulatedBench
from app.text.i18n import ENGLISH
from protocol.link_states import Presence
from ui.core.port_watcher import PortWatcher
from ui.core.preferences import Preferences
from ui.main import Assembly, WindowOptions, assemble, start
from ui.pages.diagnosis.traffic import TrafficPage
from ui.services.context import PageEntry, Services
from ui.services.page import StreamPage
from ui.style.icons import Icon

WAIT_MS = 8000
ADAPTER = PortInfo("/dev/ttyUSB0", "CP2102 USB to UART", "Silicon Labs", "0001", 0x10C4, 0xEA60, "1-1")
SECOND_ADAPTER = PortInfo("/dev/ttyACM0", "USB Single Serial", "QinHeng", "5523", 0x1A86, 0x55D3, "1-2")


class TrafficAlone(StreamPage):
    """The traffic list as a page of its own."""

    def __init__(self, services: Services) -> None:
        super().__init__("alone")
        self.traffic = TrafficPage(services)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.traffic)

    def on_batch(self, batch: Batch) -> None:
        self.traffic.on_batch(batch)


TRAFFIC_ALONE = (PageEntry("traffic", "Traffic", Icon.DIAGNOSIS, TrafficAlone),)
"""The page that needs no plots: these tests are about what is around the pages."""


class Ports:
    """The ports as the system would list them. `hold` makes a look take as long as the test wants."""

    def __init__(self, *ports: PortInfo) -> None:
        self.now: list[PortInfo] = list(ports)
        self.looks = 0
        self._may_answer = threading.Event()
        self._may_answer.set()

    def poll(self, deadline_s: float) -> list[PortInfo]:
        self.looks += 1
        self._may_answer.wait(deadline_s)
        return list(self.now)

    def hold(self) -> None:
        self._may_answer.clear()

    def release(self) -> None:
        self._may_answer.set()


@contextmanager
def window(
    qapp: QApplication,
    folder: Path,
    *,
    ports: Ports | None = None,
    options: WindowOptions | None = None,
    entries: tuple[PageEntry, ...] = TRAFFIC_ALONE,
) -> Iterator[Assembly]:
    """A shown window with its pages made; closed in good order afterwards, with no thread left."""
    options = options or WindowOptions(language="en")
    assembly = assemble(
        qapp,
        options,
        preferences=Preferences(folder / "window.ini"),
        ports=PortWatcher((ports or Ports()).poll),
        entries=entries,
    )
    try:
        start(assembly, options)
        yield assembly
    finally:
        if ports is not None:
            ports.release()
        assembly.window.close_now()
        assembly.connector.stop(2.0)
        assembly.ports.stop(2.0)
        assembly.storage.close()
        assembly.language_switch.use(ENGLISH)  # takes Qt's own translation off the application again
        assembly.window.deleteLater()
        QApplication.processEvents()


@contextmanager
def simulated(name: str, **options: object) -> Iterator[SimulatedBench]:
    """The simulated module of this name, begun with these options; forgotten afterwards."""
    try:
        yield bench.module(name, options)
    finally:
        bench.forget(name)


def wait_online(qtbot: QtBot, assembly: Assembly) -> None:
    """Until the module answers and its status is known."""

    def is_known() -> bool:
        device = assembly.connector.device
        return device.presence is Presence.ONLINE and device.known("active", assembly.connector.clock()) is not None

    qtbot.waitUntil(is_known, timeout=WAIT_MS)
