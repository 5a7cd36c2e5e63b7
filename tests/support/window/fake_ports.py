"""Ports without threads: each records what it is asked, and publishes what the test says."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any
from unittest.mock import patch

from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.engine.device import DeviceView, How, Known, StaleReason, StatusSample
from app.engine.identity import NO_EXPECTATION, Identity
from app.engine.ports import PortInfo
from app.engine.procedure import LinkView, PortLost
from app.engine.target import Target
from app.engine.transport import PortError, PortTrouble
from app.engine.worker import Batch, Connection, Job, PortState
from app.records.filing import Filed
from app.safety.journal import NoJournal
from app.store.trouble import StoreFault, StoreTrouble
from protocol.events import Event
from protocol.fields import Value
from protocol.link_states import Presence
from tests.support.window.fakes_ui import ListedPorts, window
from ui.core.port_watcher import PortWatcher
from ui.main import PAGES, Assembly
from ui.services.context import Services
from ui.services.port import Port, Ports
from ui.services.port_check import PortCheck
from ui.services.storage import Storage
from ui.style.appearance import Appearance
from ui.style.theme import Choice

VALUES: dict[str, Value] = {
    "tilt_deg": 7,
    "acceleration_g": 1.0,
    "triggered": False,
    "active": False,
    "cell_voltage_v": 4.0,
    "charging": False,
    "light_v": 0.3,
    "boot_count": 37,
}


class FakeWorker:
    """Stands in for `Worker`; `jobs` holds all submitted jobs, each with whether it was urgent."""

    def __init__(self, callback: Callable[[Batch], None], clock: Callable[[], float] = lambda: 0.0) -> None:
        self.callback, self._clock = callback, clock
        self.jobs: list[tuple[Job[Any], bool]] = []
        self.opened: list[str] = []
        self.connection = Connection()
        self.values: dict[str, Known] = {}
        self.presence = Presence.UNKNOWN
        self.identity = NO_EXPECTATION
        self.publish_every_s = self.stream_hz = 0.0
        self.restarts = self.breaks = 0
        self.is_stopped = False

    # Called by the window

    def start(self) -> None: ...

    def open(self, port: str, baud_rate: int, *_: object, **_keywords: object) -> int:
        self.opened.append(port)
        self.connection = Connection(PortState.OPENING, port, baud_rate, opening=len(self.opened))
        return len(self.opened)

    def close(self) -> None:
        self.connection = self.connection._replace(state=PortState.CLOSED)

    def submit(self, job: Job[Any], *, is_urgent: bool = False) -> Job[Any]:
        self.jobs.append((job, is_urgent))
        return job

    def confirm_identity(self, _seen: Identity | None = None, **_said: object) -> None: ...

    def treat_as_new(self, **_said: object) -> int:
        self.opened.append(self.connection.port)
        self.connection = self.connection._replace(opening=len(self.opened))
        return len(self.opened)

    def stop(self, _deadline_s: float = 2.0) -> bool:
        self.is_stopped = True
        return True

    # Called by the test

    def say(self, **values: Value) -> None:
        """Publish these values of a module that is online."""
        self.connection = self.connection._replace(state=PortState.OPEN)
        self.presence = Presence.ONLINE
        now = self._clock()
        self.values |= {key: Known(value, How.READ, now) for key, value in values.items()}
        self.hand_over()

    def unplug(self) -> None:
        trouble = PortError(PortTrouble.LOST, self.connection.port, "unplugged")
        self.connection = self.connection._replace(state=PortState.CLOSED, trouble=trouble)
        self.values = {
            key: Known(one.value, one.how, one.at, StaleReason.LINK_LOST) for key, one in self.values.items()
        }
        self.end_jobs()

    def end_jobs(self, error: Exception | None = None) -> None:
        """End all submitted jobs with an error."""
        ended = tuple(job for job, _ in self.jobs if not job.is_done)
        for job in ended:
            job.run.throw(error or PortLost(), self._clock())
            if not job.run.is_done:
                job.run.throw(error or PortLost(), self._clock())
            job.finish()
        self.hand_over(finished=ended)

    def hand_over(
        self,
        *,
        finished: tuple[Job[Any], ...] = (),
        identity: Identity | None = None,
        samples: tuple[StatusSample, ...] = (),
        events: tuple[Event, ...] = (),
        link: LinkView | None = None,
    ) -> None:
        view = DeviceView(
            MappingProxyType(dict(self.values)), self.presence, self._clock(), self.stream_hz > 0, self.stream_hz,
            restarts=self.restarts, breaks=self.breaks,
        )  # fmt: skip
        batch = Batch(
            self._clock(),
            self.connection,
            view,
            link,
            samples,
            events=events,
            finished=finished,
            identity=identity or self.identity,
        )
        self.callback(batch)

    def wanted(self, *, is_urgent: bool) -> list[Job[Any]]:
        return [job for job, urgent in self.jobs if urgent is is_urgent]


class NoStorage(Storage):
    """Keeps nothing, and has no journal."""

    @property
    def begun(self) -> None:
        return None

    def open_store(self) -> StoreTrouble:
        return StoreTrouble(StoreFault.FAILED, Path(), "none")

    def journal(self, *_: object) -> NoJournal:
        return NoJournal()


class FakePorts:
    """`Ports` with fake workers and a fake clock."""

    def __init__(self) -> None:
        self.now_s = 1000.0
        self.workers: list[FakeWorker] = []

    def serve(self, watcher: PortWatcher, storage: Storage) -> Ports:
        """In place of `Ports`, whoever makes them."""
        self.watcher = watcher
        self.connector = Ports(watcher, storage, make_worker=self.make, clock=lambda: self.now_s)
        return self.connector

    def make(self, callback: Callable[[Batch], None]) -> Any:
        self.workers.append(FakeWorker(callback, lambda: self.now_s))
        return self.workers[-1]

    def plug_in(self, device: str, **values: Value) -> tuple[Port, FakeWorker]:
        """Connect a module to the first port that is free, and publish its values."""
        first = self.connector.connections[0]
        connection = first if not first.is_requested else self.connector.add(self.make)
        worker = self.workers[self.connector.connections.index(connection)]
        connection.connect_to(Target(device, 115200))
        worker.say(**VALUES | values)
        return connection, worker

    def stop(self) -> None:
        self.connector.stop(1.0)
        self.watcher.stop(1.0)
        self.connector.deleteLater()  # its connections would keep it alive


def ports_alone(storage: Storage | None = None) -> FakePorts:
    """Without a window."""
    fake = FakePorts()
    fake.serve(PortWatcher(lambda _deadline_s: []), storage or NoStorage())
    return fake


@contextmanager
def fake_window(qapp: QApplication, folder: Path, *ports: PortInfo) -> Iterator[tuple[FakePorts, Assembly]]:
    """The program's own with all its pages, on fake ports, while the system lists these ports."""
    fake = FakePorts()
    with patch("ui.main.Ports", fake.serve), window(qapp, folder, ports=ListedPorts(*ports), entries=PAGES) as assembly:
        yield fake, assembly


@contextmanager
def fake_services(qapp: QApplication, storage: Storage | None = None) -> Iterator[tuple[FakePorts, Services]]:
    """What a page without a main window is given."""
    ports, appearance = ports_alone(storage), Appearance(qapp, Choice.LIGHT)
    yield ports, Services(ports.connector, appearance)
    appearance.choose(Choice.LIGHT)
    appearance.deleteLater()
    ports.stop()
    ports.connector.storage.close()


def stand(check: PortCheck, filed: Filed) -> None:
    """This is what came of a check that runs on a fake port."""
    check._job = None
    check._use(filed)


def show_alone(qtbot: QtBot, services: Services, page: QWidget, width: int, height: int) -> None:
    qtbot.addWidget(page)
    services.appearance.apply_theme(page)
    page.resize(width, height)
    page.show()
