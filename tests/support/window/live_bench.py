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

    def say(self, *samples: StatusSample, leave_out: str = "", **values: Value) -> None:
        """Hand over a batch with these values, and a sample of them unless samples are given; the page shows it."""
        known = {key: value for key, value in (KNOWN | values).items() if key != leave_out}
        worker, taken = self.worker, len(self.page.data.tilt)
        worker.connection, worker.number, worker.ended = OPEN, max(1, worker.number), None
        worker.values = {key: Known(value, How.READ, self.now_s) for key, value in known.items()}
        worker.stream_hz = 50.0
        state = known.get("triggered") is True, known.get("active") is True
        one = StatusSample(self.now_s, int(known["tilt_deg"]), float(known["acceleration_g"]), *state)
        worker.hand_over(samples=samples or (one,))
        self.qtbot.waitUntil(lambda: len(self.page.data.tilt) > taken)
        self.pass_time(0.0)

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
        yield Bench(qtbot, page, ports)
        qtbot.waitUntil(lambda: not page.job.is_busy)
        page.hide()
