"""The window's side of the link: what is to be connected, and what became of it. Widgets ask here, never the worker."""

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from app.device import DeviceView
from app.journal import Journal, NoJournal
from app.ports import PortInfo
from app.procedure import Procedure, Report, Result
from app.procedures.find import Found, find_rate
from app.procedures.greet import Greeting, greet
from app.procedures.lock import Locked, lock
from app.procedures.stream import StreamSwitch, watch
from app.recording import is_recording, questions_only
from app.transport import PortError
from app.worker import Batch, Connection, Job, PortState, Worker
from protocol.link_states import Presence
from ui.bridge import Bridge
from ui.link_state import GONE, LinkState, link_state
from ui.port_watch import PortWatch

_log = logging.getLogger(__name__)

RETRY_MS = 1500


@dataclass(frozen=True, slots=True)
class Target:
    """A port to connect to. `baud_rate` is where to begin; `finds_rate` goes through all rates if need be."""

    device: str
    baud_rate: int
    identity: str = ""
    """Tells the adapter from every other; empty where there is none to tell (a URL, a pseudo-terminal)."""
    title: str = ""
    finds_rate: bool = False

    @property
    def is_simulated(self) -> bool:
        return self.device.startswith("sim:")

    @property
    def is_recording(self) -> bool:
        """A capture that is played."""
        return is_recording(self.device)

    @property
    def is_recognisable(self) -> bool:
        """It can be told that the same adapter is back: by its USB identity, or because a URL or a link stands for it.

        A bare device name may be another adapter's by then.
        """
        return bool(self.identity) or "://" in self.device or Path(self.device).is_symlink()


class Connector(QObject):
    """Owns the worker. Reconnects by itself after a loss, but only to the same adapter."""

    changed = Signal()
    """Something about the link is different from before."""
    batch = Signal(object)
    """Each `Batch`, after the state was brought up to date with it."""
    came_online = Signal(object)
    """The `Target`, whenever a module answers on it."""

    def __init__(
        self,
        ports: PortWatch,
        *,
        make_worker: Callable[[Callable[[Batch], None]], Worker] = Worker,
        clock: Callable[[], float] = time.monotonic,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.clock = clock
        self.stream = StreamSwitch(is_wanted=False)
        self._bridge = Bridge(self)
        self._bridge.batch.connect(self._take)
        self._worker = make_worker(self._bridge.deliver)
        self._ports = ports
        self._ports.listed.connect(self._look_for_adapter)
        self._target: Target | None = None
        self._last: Batch | None = None
        self._greeting: Greeting | None = None
        self._endings: dict[Job[Any], Callable[[Job[Any]], None]] = {}
        self._finding: Job[Found] | None = None
        self._greeter: Job[Greeting] | None = None
        self._is_wanted = False
        self._is_recognisable = False
        self._is_reconnecting = False
        self._journal_of: Callable[[Target | None], Journal] = lambda _target: NoJournal()
        self._trouble: PortError | None = None
        """The last; it stays in sight between two attempts to reconnect."""
        self._is_ordered = False
        """An opening was ordered of which no batch has told yet."""
        self._retry = QTimer(self)
        self._retry.setInterval(RETRY_MS)
        self._retry.timeout.connect(self._try_again)
        self._worker.start()

    # What is known

    @property
    def target(self) -> Target | None:
        return self._target

    @property
    def last(self) -> Batch | None:
        return self._last

    @property
    def device(self) -> DeviceView:
        return DeviceView() if self._last is None else self._last.device

    @property
    def connection(self) -> Connection:
        return Connection() if self._last is None else self._last.connection

    @property
    def is_open(self) -> bool:
        return self.connection.state is PortState.OPEN

    @property
    def is_wanted(self) -> bool:
        """Somebody asked for a connection and has not ended it, whether or not it stands."""
        return self._is_wanted

    @property
    def state(self) -> LinkState:
        connection = self.connection
        if self._is_ordered and self._target is not None:
            connection = Connection(PortState.OPENING, self._target.device, self._target.baud_rate)
        if self._is_reconnecting:
            connection = replace(connection, trouble=self._trouble)
        elif not self._is_wanted and connection.state is PortState.CLOSED:
            connection = replace(connection, trouble=None)  # nobody wants that port any more
        return link_state(
            connection,
            self.device,
            self._greeting,
            is_reconnecting=self._is_reconnecting,
            is_finding=self._finding is not None,
        )

    @property
    def is_recording(self) -> bool:
        """There is no module: a capture is played, and nothing but questions is asked."""
        return self._target is not None and self._target.is_recording and self._is_wanted

    @property
    def ports(self) -> PortWatch:
        return self._ports

    @property
    def is_active(self) -> bool:
        """As far as is known the module will fire by its thresholds. A doubtful "active" counts as active; one that
        was only recorded does not."""
        if self.is_recording:
            return False
        known = self.device.known("active", self.clock())
        return known is not None and known.value is True

    # What can be done

    def connect_to(self, target: Target) -> None:
        """Open `target`, closing what is open."""
        self._is_wanted = True
        self._is_recognisable = target.is_recognisable
        self._set_reconnecting(is_reconnecting=False)
        self._open(target)

    def disconnect_port(self) -> None:
        self._is_wanted = False
        self._set_reconnecting(is_reconnecting=False)
        self._is_ordered = False
        self._worker.close()
        self.changed.emit()

    def find_rate(self) -> None:
        """Go through all baud rates on the open port."""
        if self._finding is not None or not self.is_open:
            return
        self._finding = self.run(find_rate(self.connection.baud_rate), self._end_finding)
        self.changed.emit()

    def log_to(self, journal_of: Callable[[Target | None], Journal]) -> None:
        """Where a LOCK is written down, by the module that it is for."""
        self._journal_of = journal_of

    def lock(self, then: Callable[[Locked | None], None]) -> None:
        """Put the module into standby; `then` gets what the module says of it, None where the port is gone."""

        def end(job: Job[Locked]) -> None:
            then(None if job.run.error is not None else job.outcome())

        self.run(lock(self._journal_of(self.target)), end, is_urgent=True)

    def run(
        self,
        procedure: Procedure[Result],
        then: Callable[[Job[Result]], None],
        *,
        is_urgent: bool = False,
        on_progress: Callable[[Report], None] | None = None,
    ) -> Job[Result]:
        """Hand a procedure to the worker; `then` is called in the window's thread when it has ended, `on_progress`
        in the worker's: it may only remember what it is given."""
        job = Job(questions_only(procedure) if self.is_recording else procedure, on_progress)
        self._endings[job] = then
        return self._worker.submit(job, is_urgent=is_urgent)

    def stop(self, deadline_s: float) -> bool:
        """Close the port and end the worker, within `deadline_s`; whether it ended."""
        self._is_wanted = False
        self._retry.stop()
        self._bridge.close()
        return self._worker.stop(deadline_s)

    # What happens

    def _open(self, target: Target) -> None:
        self._target = target
        self._greeting = None
        self._finding = self._greeter = None
        self._is_ordered = True
        background = partial(watch, self.stream)
        if target.is_recording:
            background = partial(_watch_recording, self.stream)
        self._worker.open(target.device, target.baud_rate, background)
        if target.finds_rate:
            self._finding = self.run(find_rate(target.baud_rate), self._end_finding)
        else:
            self._greeter = self.run(greet(), self._end_greeting)
        self.changed.emit()

    def _take(self, batch: Batch) -> None:
        before, was_online = self.state, self._is_online()
        if self._last is None or batch.connection != self._last.connection:
            _log.info("Port: %s", batch.connection)
        self._last = batch
        if batch.connection.state is not PortState.CLOSED or batch.connection.trouble is not None:
            self._is_ordered = False
        for job in batch.finished:
            then = self._endings.pop(job, None)
            if then is not None:
                then(job)
        self._watch_for_loss(batch.connection)
        if self._is_online() and not was_online and self._target is not None:
            self.came_online.emit(self._target)
        self.batch.emit(batch)
        if self.state != before:
            self.changed.emit()

    def _is_online(self) -> bool:
        return self.is_open and self.device.presence is Presence.ONLINE

    def _watch_for_loss(self, connection: Connection) -> None:
        if connection.state is PortState.OPEN:
            self._set_reconnecting(is_reconnecting=False)
        trouble = connection.trouble
        self._trouble = trouble or self._trouble
        if connection.state is PortState.CLOSED and trouble is not None and trouble.trouble in GONE:
            self._set_reconnecting(is_reconnecting=self._is_wanted and self._is_recognisable)

    def _set_reconnecting(self, *, is_reconnecting: bool) -> None:
        if is_reconnecting == self._is_reconnecting:
            return
        self._is_reconnecting = is_reconnecting
        if is_reconnecting:
            self._retry.start()
        else:
            self._retry.stop()

    def _try_again(self) -> None:
        target = self._target
        if target is None or self.connection.state is PortState.OPENING:
            return
        if target.identity:
            self._ports.refresh()
        else:
            self._open(target)

    def _look_for_adapter(self) -> None:
        target = self._target
        if not self._is_reconnecting or target is None or self.connection.state is not PortState.CLOSED:
            return
        same = [port for port in self._ports.ports if port.identity == target.identity]
        if len(same) == 1:
            self._open(replace(target, device=same[0].device))

    def _end_greeting(self, job: Job[Greeting]) -> None:
        if job is self._greeter and job.run.error is None:
            self._greeting = job.outcome()

    def _end_finding(self, job: Job[Found]) -> None:
        if job is not self._finding:
            return  # of a port that was left meanwhile
        self._finding = None
        if job.run.error is None and job.outcome().baud_rate is None:
            _log.info("No module answered at any of %s baud", job.outcome().tried)
            self._greeter = self.run(greet(), self._end_greeting)  # says what is on the line instead


def _watch_recording(switch: StreamSwitch) -> Procedure[None]:
    return questions_only(watch(switch))


def from_port(port: PortInfo, baud_rate: int, *, finds_rate: bool = False) -> Target:
    """What to connect to for a listed port."""
    return Target(port.device, baud_rate, port.identity, port.description, finds_rate)

