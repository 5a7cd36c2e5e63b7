"""The port whose module the pages show, one of those that are open. Widgets use this, never the worker."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from app.engine.procedure import Procedure, Report, Result
from app.engine.target import Target
from app.engine.worker import PUBLISH_EVERY_S, Batch, Job, PortState, Worker
from app.store.stream_memory import StreamMemory
from protocol.link_states import Presence
from ui.core.port_connection import PortConnection
from ui.core.port_watcher import PortWatcher

MakeWorker = Callable[[Callable[[Batch], None]], Worker]
SETTLE_MS = 1000
"""How long a switch to another module waits for running procedures to end."""


class Connector(QObject):
    """Shows one of several `PortConnection`s, the current one, to the pages.

    `choose` makes another one current. The pages see the same as after a new connection: the port being opened, then
    open, then the module. The other ports stay open, reconnect and lock independently. Pages run their procedures by
    this class, which ends them before it switches.
    """

    changed = Signal()
    """Of the current port; as the five below. See `PortConnection`."""
    batch = Signal(object)
    invalidated = Signal()
    came_online = Signal(object)
    stream_left_on = Signal()
    slept = Signal(float)
    leaving = Signal()
    """Another port was chosen and this one is still current: pages finish with its module now."""
    chosen = Signal()
    """Another port is now current; emitted after `invalidated`, before the pages are updated."""
    added = Signal(object)
    """A `PortConnection`."""
    removed = Signal(object)

    def __init__(
        self,
        ports: PortWatcher,
        *,
        make_worker: MakeWorker = Worker,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__()
        self.clock = clock
        self.ports = ports
        self._memory_of: Callable[[Target], StreamMemory] | None = None
        self._connections: list[PortConnection] = []
        self._leaving: set[PortConnection] = set()
        self._jobs: set[Job[Any]] = set()
        """Of the pages, on the current port."""
        self._next: PortConnection | None = None
        self._settling = QTimer(self, singleShot=True, interval=SETTLE_MS)
        self._settling.timeout.connect(self._switch)
        self.invalidated.connect(self._drop_jobs)
        self._current = self.add(make_worker)
        self._relay(self._current)

    # Several ports

    @property
    def current(self) -> PortConnection:
        return self._current

    @property
    def connections(self) -> tuple[PortConnection, ...]:
        """All ports, in the order in which they were added."""
        return tuple(self._connections)

    @property
    def is_any_active(self) -> bool:
        """A module on any open port may fire by its thresholds, as far as is known."""
        return any(one.is_open and one.is_active for one in self._connections)

    def add(self, make_worker: MakeWorker = Worker) -> PortConnection:
        """Another port, not yet connected; the current one stays current."""
        connection = PortConnection(self.ports, make_worker=make_worker, clock=self.clock, parent=self)
        connection.set_shown(is_shown=not self._connections)
        if self._memory_of is not None:
            connection.remember_stream(self._memory_of)
        self._connections.append(connection)
        self.added.emit(connection)
        return connection

    def remove(self, connection: PortConnection) -> None:
        """Close a port that is not current, and drop it once it is closed."""
        if connection is self._current or connection is self._next or connection not in self._connections:
            return
        self._connections.remove(connection)
        self._leaving.add(connection)
        connection.batch.connect(partial(self._on_removed_batch, connection))
        connection.disconnect_port()
        self.removed.emit(connection)

    def choose(self, connection: PortConnection) -> None:
        """Show this port's module in the pages, once their procedures on the current one have ended."""
        if connection is self._current or connection not in self._connections:
            return
        self._next = connection
        self.leaving.emit()
        for job in self._jobs:
            job.cancel()
        if self._jobs:
            self._settling.start()
        else:
            self._switch()

    # What the pages do

    def connect_to(self, target: Target) -> None:
        """Open `target` in place of the current port; a port that is open already is chosen."""
        others = (one for one in self._connections if one is not self._current and one.is_requested)
        same = next((one for one in others if one.target is not None and one.target.key == target.key), None)
        if same is not None:
            self.choose(same)
        else:
            self._current.connect_to(target)

    def find_rate(self) -> None:
        """As a slot: of the port that is then the current one."""
        self._current.find_rate()

    def want_stream(self, *, is_wanted: bool) -> None:
        """Whether the shown page needs the serial output."""
        self._current.stream.is_wanted = is_wanted

    def set_drawing_interval(self, every_s: float = PUBLISH_EVERY_S) -> None:
        """How often the shown page draws the current port."""
        self._current.set_shown(is_shown=True, every_s=every_s)

    def remember_stream(self, memory_of: Callable[[Target], StreamMemory]) -> None:
        self._memory_of = memory_of
        for connection in self._connections:
            connection.remember_stream(memory_of)

    @property
    def is_busy(self) -> bool:
        """A procedure that a person started is running."""
        return bool(self._jobs)

    def run(
        self,
        procedure: Procedure[Result],
        then: Callable[[Job[Result]], None],
        *,
        is_urgent: bool = False,
        on_progress: Callable[[Report], None] | None = None,
    ) -> Job[Result]:
        def end(ended: Job[Result]) -> None:
            if is_urgent or ended in self._jobs:  # else it is of a module that is no longer shown
                self._jobs.discard(ended)
                then(ended)
            if self._next is not None and not self._jobs:
                self._switch()

        job = self._current.run(procedure, end, is_urgent=is_urgent, on_progress=on_progress)
        if not is_urgent:
            self._jobs.add(job)
        return job

    def stop(self, deadline_s: float) -> bool:
        """Close all ports and end their workers, within `deadline_s`; whether they ended."""
        self._settling.stop()
        ends_at = time.monotonic() + deadline_s
        every = [*self._connections, *self._leaving]
        for connection in every if len(every) > 1 else ():
            connection.disconnect_port()  # all at once; `stop` waits for one after the other
        have_ended = [one.stop(max(0.0, ends_at - time.monotonic())) for one in every]
        return all(have_ended)

    # What happens

    def _relay(self, connection: PortConnection) -> None:
        for mine, its in self._pairs(connection):
            its.connect(mine)

    def _pairs(self, connection: PortConnection) -> tuple[tuple[Any, Any], ...]:
        return (
            (self.changed, connection.changed),
            (self.batch, connection.batch),
            (self.invalidated, connection.invalidated),
            (self.came_online, connection.came_online),
            (self.stream_left_on, connection.stream_left_on),
            (self.slept, connection.slept),
        )

    def _switch(self) -> None:
        self._settling.stop()
        before, (now, self._next) = self._current, (self._next, None)
        if now is None or now not in self._connections:
            return
        for mine, its in self._pairs(before):
            its.disconnect(mine)
        now.stream.is_wanted, before.stream.is_wanted = before.stream.is_wanted, False
        before.set_shown(is_shown=False)
        now.set_shown(is_shown=True)
        self._current = now
        self._show_opening(now)
        self._relay(now)
        self.batch.emit(replace(now.last, samples=(), events=(), finished=()))
        self.changed.emit()
        if now.is_open and now.device.presence is Presence.ONLINE and now.target is not None:
            self.came_online.emit(now.target)

    def _show_opening(self, connection: PortConnection) -> None:
        """Clear the pages: no value of the previous module, and nothing prepared for it, may remain."""
        with connection.shown_as_opening():
            self.invalidated.emit()
            self.chosen.emit()
            self.batch.emit(connection.last)
            self.changed.emit()

    def _drop_jobs(self) -> None:
        """What still runs on the former module ends soon; what it found reaches no page."""
        jobs, self._jobs = self._jobs, set()
        for job in jobs:
            job.cancel()

    def _on_removed_batch(self, connection: PortConnection, batch: Batch) -> None:
        if batch.connection.state is PortState.CLOSED and connection in self._leaving:
            self._leaving.remove(connection)
            QTimer.singleShot(0, self, partial(_end, connection))


def _end(connection: PortConnection) -> None:
    connection.stop(0.0)
    connection.deleteLater()
