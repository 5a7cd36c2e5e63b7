"""A Live page that a test feeds batch by batch, on a fake clock."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.engine.conversation import How, Known, StatusSample
from app.engine.worker import Connection, PortState
from protocol.fields import Value
from tests.support.window.fake_ports import VALUES, FakePorts, FakeWorker, fake_services, show_alone
from tests.support.window.steps import Driver
from ui.pages.live.page import LivePage
from ui.services.context import Services
from ui.session.ports import Ports

OPEN = Connection(PortState.OPEN, "/dev/ttyUSB0", 115200)
KNOWN: dict[str, Value] = VALUES | {
    "tilt_deg": 12,
    "cell_voltage_v": 3.94,
    "attitude_threshold_deg": 60,
    "freefall_acceleration_g": 0.5,
    "light_threshold_v": 1.8,
}


@dataclass
class Bench(Driver):
    """A Live page on a fake clock."""

    qtbot: QtBot
    page: LivePage
    ports: FakePorts
    services: Services
    stream_hz: float = 50.0

    @property
    def connector(self) -> Ports:
        return self.ports.ports

    @property
    def worker(self) -> FakeWorker:
        return self.ports.workers[0]

    @property
    def now_s(self) -> float:
        return self.ports.now_s

    @now_s.setter
    def now_s(self, now_s: float) -> None:
        self.ports.now_s = now_s

    @property
    def root(self) -> QWidget:
        return self.page

    def say(self, *samples: StatusSample, is_streaming: bool = True, leave_out: str = "", **values: Value) -> None:
        """Hand over a batch with these values, and wait until the page shows it; see `hand_over`."""
        taken = len(self.page.data.tilt)
        self.hand_over(*samples, is_streaming=is_streaming, leave_out=leave_out, **values)
        self.qtbot.waitUntil(lambda: len(self.page.data.tilt) > taken)
        self.page.refresh()
        self.page.draw()

    def hand_over(
        self, *samples: StatusSample, is_streaming: bool = True, leave_out: str = "", **values: Value
    ) -> None:
        """Hand over a batch with these values, and with a sample of them unless samples are given."""
        known = {key: value for key, value in (KNOWN | values).items() if key != leave_out}
        worker = self.worker
        worker.connection, worker.number, worker.ended = OPEN, max(1, worker.number), None
        worker.values = {key: Known(value, How.READ, self.now_s) for key, value in known.items()}
        worker.stream_hz = self.stream_hz if is_streaming else 0.0
        state = known.get("triggered") is True, known.get("active") is True
        one = StatusSample(self.now_s, int(known["tilt_deg"]), float(known["acceleration_g"]), *state)
        worker.hand_over(samples=samples or (one,))

    def pass_time(self, seconds: float) -> None:
        self.now_s += seconds
        self.page.refresh()
        self.page.draw()


@contextmanager
def live_bench(qtbot: QtBot, qapp: QApplication) -> Iterator[Bench]:
    """Show a Live page with a fake worker."""
    with fake_services(qapp) as (ports, services):
        page = LivePage(services)
        show_alone(qtbot, services, page, 876, 500)
        yield Bench(qtbot, page, ports, services)
        qtbot.waitUntil(lambda: not page.job.is_writing)
        page.hide()
