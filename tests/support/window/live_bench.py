"""A Live page that a test feeds batch by batch, with a clock that the test moves."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QPushButton, QWidget
from pytestqt.qtbot import QtBot

from app.engine.device import DeviceView, How, Known, StatusSample
from app.engine.worker import Batch, Connection, Job, PortState
from app.safety.journal import NoJournal
from protocol.fields import Value
from protocol.link_states import Presence
from ui.core.connector import Connector
from ui.core.port_watcher import PortWatcher
from ui.core.texts import Texts
from ui.pages.live.page import LivePage
from ui.services.context import Services
from ui.services.lock import LockControl
from ui.style.appearance import Appearance
from ui.style.theme import Choice

OPEN = Connection(PortState.OPEN, "/dev/ttyUSB0", 115200)
KNOWN: dict[str, Value] = {
    "tilt_deg": 12,
    "acceleration_g": 1.0,
    "triggered": False,
    "active": False,
    "cell_voltage_v": 3.94,
    "charging": False,
    "light_v": 0.3,
    "boot_count": 37,
    "attitude_threshold_deg": 60,
    "freefall_acceleration_g": 0.5,
    "light_threshold_v": 1.8,
}


class SilentWorker:
    """A worker without a port; the test hands out the batches."""

    def __init__(self, callback: Callable[[Batch], None]) -> None:
        self.callback = callback

    def start(self) -> None: ...

    def open(self, *_: object) -> None: ...

    def close(self) -> None: ...

    def submit(self, job: Job[Any]) -> Job[Any]:
        return job

    def stop(self, _deadline_s: float = 2.0) -> bool:
        return True


@dataclass
class Bench:
    """A page with a clock that stands still until it is moved."""

    qtbot: QtBot
    page: LivePage
    connector: Connector
    texts: Texts
    appearance: Appearance
    worker: SilentWorker
    now_s: float = 1000.0
    stream_hz: float = 50.0

    def say(self, *samples: StatusSample, is_streaming: bool = True, leave_out: str = "", **values: Value) -> None:
        """A batch in which all of this is known now, with a sample of it where none is given."""
        taken = len(self.page.data.tilt)
        self.hand_over(*samples, is_streaming=is_streaming, leave_out=leave_out, **values)
        self.qtbot.waitUntil(lambda: len(self.page.data.tilt) > taken)
        self.page.refresh()
        self.page.draw()

    def hand_over(
        self, *samples: StatusSample, is_streaming: bool = True, leave_out: str = "", **values: Value
    ) -> None:
        """The same, left to the window's own turns."""
        known = {key: value for key, value in (KNOWN | values).items() if key != leave_out}
        device = DeviceView(
            MappingProxyType({key: Known(value, How.READ, self.now_s) for key, value in known.items()}),
            Presence.ONLINE,
            self.now_s,
            is_streaming,
            self.stream_hz if is_streaming else 0.0,
        )
        state = known.get("triggered") is True, known.get("active") is True
        one = StatusSample(self.now_s, int(known["tilt_deg"]), float(known["acceleration_g"]), *state)
        self.worker.callback(Batch(self.now_s, OPEN, device, None, samples or (one,)))

    def pass_time(self, seconds: float) -> None:
        self.now_s += seconds
        self.page.refresh()
        self.page.draw()

    def find(self, kind: type[Any], name: str) -> Any:
        found = self.page.findChild(kind, name)
        assert found is not None, name
        return found

    def click(self, name: str, kind: type[QWidget] = QPushButton) -> None:
        self.qtbot.mouseClick(self.find(kind, name), Qt.MouseButton.LeftButton)


@contextmanager
def live_bench(qtbot: QtBot, qapp: QApplication) -> Iterator[Bench]:
    """A shown Live page without a worker, put away afterwards."""
    workers: list[SilentWorker] = []

    def make(callback: Callable[[Batch], None]) -> Any:
        workers.append(SilentWorker(callback))
        return workers[-1]

    moment: list[Bench] = []
    ports = PortWatcher(lambda _deadline_s: [])
    connector = Connector(ports, make_worker=make, clock=lambda: moment[0].now_s if moment else 1000.0)
    texts, appearance = Texts(), Appearance(qapp, Choice.LIGHT)
    page = LivePage(Services(connector, texts, appearance, LockControl(connector, lambda _target: NoJournal())))
    connector.batch.connect(page.on_batch)
    qtbot.addWidget(page)
    bench = Bench(qtbot, page, connector, texts, appearance, workers[0])
    moment.append(bench)
    page.resize(876, 500)
    page.show()
    yield bench
    qtbot.waitUntil(lambda: not page.save.is_saving)
    page.hide()
    appearance.choose(Choice.LIGHT)
    appearance.deleteLater()  # what is connected to it keeps the page
    connector.stop(1.0)
    ports.stop(1.0)
