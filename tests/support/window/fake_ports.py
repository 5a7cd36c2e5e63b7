"""Ports without threads: each records what it is asked, and publishes what the test says."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any
from unittest.mock import patch

from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.engine.conversation import ConversationView, How, Interrupted, Known, StatusSample
from app.engine.ports import PortInfo
from app.engine.procedure import Job
from app.engine.target import Target
from app.engine.transport import PortError, PortErrorKind
from app.engine.worker import Batch, Connection, PortState
from app.records.filing import Filed
from app.safety.journal import Journal
from app.store.fact_store import StoreError
from protocol.events import Ended, EndReason
from protocol.fields import Value
from tests.support.window.fakes_ui import ListedPorts, window
from ui.core.port_watcher import PortWatcher
from ui.main import PAGES, Assembly
from ui.services.context import Services
from ui.services.page import Page
from ui.services.storage import Storage
from ui.session.check import ModuleCheck
from ui.session.port import Port
from ui.session.ports import Ports
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


SETTINGS: dict[str, Value] = {
    "light_threshold_v": 1.0,
    "attitude_threshold_deg": 60,
    "freefall_acceleration_g": 0.5,
    "freefall_time_s": 1.0,
}
"""Everything that can be read of the settings."""


class FakeWorker:
    """Stands in for `Worker`; `jobs` holds all submitted jobs, each with whether it was urgent."""

    def __init__(self, callback: Callable[[Batch], None], clock: Callable[[], float] = lambda: 0.0) -> None:
        self.callback, self._clock = callback, clock
        self.jobs: list[tuple[Job[Any], bool]] = []
        self.opened: list[str] = []
        self.connection = Connection()
        self.number = 0
        """Of the conversation that goes on, or ended last."""
        self.began_at = 0.0
        self.values: dict[str, Known] = {}
        self.ended: Ended | None = None
        self.publish_every_s = self.stream_hz = 0.0

    # Called by the window

    def start(self) -> None: ...

    def open(self, port: str, baud_rate: int, *_: object, **_keywords: object) -> int:
        self.opened.append(port)
        self.connection = Connection(PortState.OPENING, port, baud_rate, opening=len(self.opened))
        return len(self.opened)

    def close(self) -> None:
        self.connection = self.connection._replace(state=PortState.CLOSED)
        self.end(EndReason.CLOSED)

    def submit(self, job: Job[Any], *, is_urgent: bool = False) -> Job[Any]:
        self.jobs.append((job, is_urgent))
        return job

    def treat_as_another(self) -> None:
        self.end(EndReason.ANOTHER)

    def stop(self, _deadline_s: float = 2.0) -> bool:
        return True

    # Called by the test

    def begin(self, **values: Value) -> None:
        """Another conversation begins, in which this is read."""
        self.number += 1
        self.values, self.ended, self.began_at = {}, None, self._clock()
        self.connection = self.connection._replace(state=PortState.OPEN)
        self.say(**values)

    def say(self, **values: Value) -> None:
        """Publish these values of the module; the first ones begin a conversation."""
        if self.number == 0 or self.ended is not None:
            self.begin(**values)
            return
        self.connection = self.connection._replace(state=PortState.OPEN)
        now = self._clock()
        self.values |= {key: Known(value, How.READ, now) for key, value in values.items()}
        self.hand_over()

    def end(self, reason: EndReason) -> None:
        """The conversation ends, and with it every job but LOCK."""
        if self.number > 0 and self.ended is None:
            self.ended = Ended(reason, self._clock())
        self.end_jobs(Interrupted(reason))

    def unplug(self) -> None:
        trouble = PortError(PortErrorKind.LOST, self.connection.port, "unplugged")
        self.connection = self.connection._replace(state=PortState.CLOSED, trouble=trouble)
        self.end(EndReason.PORT_LOST)

    def end_jobs(self, error: Exception | None = None) -> None:
        """End all submitted jobs with an error."""
        ended = tuple(job for job, _ in self.jobs if not job.is_done)
        for job in ended:
            job.stop(error or Interrupted(EndReason.SILENT), self._clock())
            job.finish()
        self.hand_over(finished=ended)

    def finish(self, job: Job[Any], result: object) -> None:
        """This is what came of a job."""
        job.has_ended = True
        job._result = result
        job.finish()
        self.hand_over(finished=(job,))

    @property
    def view(self) -> ConversationView:
        return ConversationView(
            number=self.number,
            began_at=self.began_at,
            ended=self.ended,
            values=MappingProxyType(dict(self.values)),
            is_streaming=self.stream_hz > 0 and self.ended is None,
            stream_hz=self.stream_hz,
        )

    def hand_over(self, *, finished: tuple[Job[Any], ...] = (), samples: tuple[StatusSample, ...] = ()) -> None:
        self.callback(Batch(self._clock(), self.connection, self.view, None, samples, finished=finished))

    def wanted(self, *, is_urgent: bool) -> list[Job[Any]]:
        return [job for job, urgent in self.jobs if urgent is is_urgent]


class NoStorage(Storage):
    """Keeps nothing, and has no journal."""

    @property
    def begun(self) -> None:
        return None

    def open_store(self) -> StoreError:
        return StoreError("It cannot be used.")

    def journal(self, *_: object) -> Journal:
        return Journal()


class FakePorts:
    """`Ports` with fake workers and a fake clock."""

    def __init__(self) -> None:
        self.now_s = 1000.0
        self.workers: list[FakeWorker] = []

    def serve(self, watcher: PortWatcher, storage: Storage) -> Ports:
        """In place of `Ports`, whoever makes them."""
        self.watcher = watcher
        self.ports = Ports(watcher, storage, make_worker=self.make, clock=lambda: self.now_s)
        return self.ports

    def make(self, callback: Callable[[Batch], None], _make_lock: object = None) -> Any:
        self.workers.append(FakeWorker(callback, lambda: self.now_s))
        return self.workers[-1]

    def plug_in(self, device: str, **values: Value) -> tuple[Port, FakeWorker]:
        """Connect a module to the first port that is free, and publish its values."""
        first = self.ports.all[0]
        connection = first if not first.is_requested else self.ports.add(self.make)
        worker = self.workers[self.ports.all.index(connection)]
        connection.connect_to(Target(device, 115200))
        worker.say(**VALUES | SETTINGS | values)
        return connection, worker

    def stop(self) -> None:
        self.ports.stop(1.0)
        self.watcher.stop(1.0)
        self.ports.deleteLater()  # its all would keep it alive


def ports_alone(storage: Storage | None = None) -> FakePorts:
    """Without a window."""
    fake = FakePorts()
    fake.serve(PortWatcher(lambda _deadline_s: []), storage or NoStorage())
    return fake


@contextmanager
def fake_window(qapp: QApplication, folder: Path, *ports: PortInfo) -> Iterator[tuple[FakePorts, Assembly]]:
    """The program's own with all its pages, on fake ports, while the system lists these ports."""
    fake = FakePorts()
    with (
        patch("ui.main.Ports", fake.serve),
        window(qapp, folder, listed=ListedPorts(*ports), entries=PAGES) as assembly,
    ):
        yield fake, assembly


@contextmanager
def fake_services(qapp: QApplication, storage: Storage | None = None) -> Iterator[tuple[FakePorts, Services]]:
    """What a page without a main window is given."""
    ports, appearance = ports_alone(storage), Appearance(qapp, Choice.LIGHT)
    yield ports, Services(ports.ports, appearance)
    appearance.choose(Choice.LIGHT)
    appearance.deleteLater()
    ports.stop()
    ports.ports.storage.close()


def stand(check: ModuleCheck, filed: Filed) -> None:
    """This is what came of a check that runs on a fake port."""
    check._job = None
    check._end_filing(filed)


def show_alone(qtbot: QtBot, services: Services, page: QWidget, width: int, height: int) -> None:
    qtbot.addWidget(page)
    services.appearance.style(page)
    if isinstance(page, Page):
        page.show_module(services.ports.module)
        services.ports.shown.connect(page.show_module)
    page.resize(width, height)
    page.show()
