"""All that belongs to one connection, and all connections, one of which the pages show. Widgets use this, never the
worker."""

import logging
import time
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import TYPE_CHECKING, Any
from weakref import WeakSet

from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtWidgets import QWidget

from app.engine.identity import Expected
from app.engine.procedure import Procedure, Report, Result
from app.engine.snapshots import Snapshot
from app.engine.target import Target
from app.engine.worker import PUBLISH_EVERY_S, Batch, Job, PortState, Worker
from app.safety.journal import Journal
from app.store.fact_store import Store
from app.store.fired import claim_fired, note_triggered
from app.store.left_active import KnownAs
from app.store.rows import Row
from protocol.link_states import Presence
from ui.core.module_memory import PortView
from ui.core.port_connection import MakeWorker, PortConnection
from ui.core.port_watcher import PortWatcher
from ui.services.lock import PortLock
from ui.services.module_name import BeforeNew, ModuleName
from ui.services.storage import Storage

if TYPE_CHECKING:
    from app.preflight.findings import Person
    from app.settings.profiles import Profile
    from ui.services.port_check import PortCheck

_log = logging.getLogger(__name__)
TICK_MS = 250
SETTLE_MS = 1000
"""How long a switch to another module waits for running procedures to end."""


class Port(PortConnection):
    """One connection with its module's name, LOCK, recording, journal and last check."""

    def __init__(
        self,
        watcher: PortWatcher,
        storage: Storage,
        *,
        before_new: BeforeNew,
        make_worker: MakeWorker | None,
        clock: Callable[[], float],
        parent: QObject,
    ) -> None:
        self.recording = storage.new_recording(self)
        make_worker = make_worker or (lambda deliver: Worker(self.recording.recorded(deliver)))
        super().__init__(watcher, storage.stream_memory, make_worker=make_worker, clock=clock, parent=parent)
        self._storage = storage
        self.module = ModuleName(self, storage, before_new)
        self.lock = PortLock(self, self.journal)
        self.module.changed.connect(lambda: self.recording.name_module(self.module.name))
        self.check: PortCheck | None = None
        """The last one of this module, whoever began it."""
        self.invalidated.connect(self._drop_check)
        self._triggered_as: set[tuple[str, str]] = set()
        """By connection and name of the modules whose TRIGGERED is in the store."""
        self.batch.connect(self._note_triggered)
        self.module.changed.connect(self._claim_fired)

    def expected_at(self, target: Target) -> Expected | None:
        return self.module.expected_at(target)

    def _derive_view(self) -> PortView:
        return super()._derive_view()._replace(recording=self.recording.sign)

    @property
    def known_as(self) -> KnownAs:
        return KnownAs(self.module.name, self.kept.run, is_in_doubt=not self.identity.is_settled)

    def journal(self) -> Journal:
        """With what the module is known by now."""
        return self._storage.journal(self.target, self.known_as)

    def _note_triggered(self, batch: Batch) -> None:
        """A TRIGGERED that was seen stays with the module: no verdict before it holds."""
        known = batch.device.values.get("triggered")
        is_reported = known is not None and known.value is True and not known.is_stale
        is_reported = is_reported or any(sample.triggered for sample in batch.samples)
        if self.is_open and is_reported:
            self._keep_triggered(self.module.name)

    def _keep_triggered(self, name: str) -> None:
        store, target, seen = self._storage.store, self.target, (self.kept.run, name)
        if not isinstance(store, Store) or target is None or seen in self._triggered_as:
            return
        self._triggered_as.add(seen)
        note = partial(note_triggered, module=name, port=target.device, adapter=target.identity)
        store.write(note).add_done_callback(_log_trouble)

    def _claim_fired(self) -> None:
        """What fired here without a name was the module that a person names now."""
        store, target, name = self._storage.store, self.target, self.module.name
        if not name or not isinstance(store, Store) or target is None:
            return
        if (self.kept.run, "") in self._triggered_as:
            self._triggered_as.add((self.kept.run, name))
        claim = partial(claim_fired, module=name, port=target.device, adapter=target.identity)
        store.write(claim).add_done_callback(_log_trouble)

    def keep_as_found(self) -> Callable[[Snapshot], Future[Row] | None] | None:
        """For the worker's thread, which may be late: keeps the settings before the first write; None once they are."""
        kept, port, name = self.kept, self.connection.port, self.module.name

        def keep(snapshot: Snapshot) -> Future[Row] | None:
            kept.as_found = snapshot
            return self._storage.store_snapshot(snapshot, port, name)

        return keep if kept.as_found is None else None

    @property
    def is_checking(self) -> bool:
        return self.check is not None and self.check.is_running

    def begin_check(self, profile: "Profile", person: "Person", *, is_enabling: bool) -> "PortCheck":
        """In place of the last one, which is void then. See `PortCheck`."""
        from ui.services.port_check import NEWER, PortCheck  # the first paint does not wait for it

        if self.check is not None:
            self.check.set_void(NEWER)
            self._drop_check()
        self.check = PortCheck(
            self, self.module, self._storage, self.journal(), profile, person, is_enabling=is_enabling
        )
        return self.check

    def _drop_check(self) -> None:
        check, self.check = self.check, None
        if check is not None:
            check.drop()


def _log_trouble(written: Future[None]) -> None:
    error = None if written.cancelled() else written.exception()
    if error is not None:
        _log.warning("That a module may have fired is not kept: %s", error)


class Ports(QObject):
    """Shows one of several `Port`s, the current one, to the pages.

    `choose` makes another one current. The pages see the same as after a new connection: the port being opened, then
    open, then the module. The other ports stay open, reconnect and lock independently. Pages run their procedures by
    this class, which ends them before it switches.
    """

    changed = Signal()
    """Of the current port; as the eleven below. See `PortConnection`, `ModuleName.changed` and `PortLock`."""
    batch = Signal(object)
    invalidated = Signal()
    disconnected = Signal()
    came_online = Signal(object)
    stream_left_on = Signal()
    slept = Signal(float)
    contradicted = Signal(object)
    renamed = Signal()
    broke_in_doubt = Signal()
    label_wanted = Signal()
    """A person wants to print the label of the shown module."""
    lock_changed = Signal()
    notified = Signal(str)
    any_changed = Signal()
    """Of any port."""
    ticked = Signal()
    """An age that is shown of the current port is another one."""
    leaving = Signal()
    """Another port was chosen and this one is still current: pages finish with its module now."""
    chosen = Signal()
    """Another port is now current; emitted after `invalidated`, before the pages are updated."""
    added = Signal(object)
    """A `Port`."""
    removed = Signal(object)

    def __init__(
        self,
        watcher: PortWatcher,
        storage: Storage,
        *,
        make_worker: MakeWorker | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """`make_worker`: of the first port; None makes one whose batches are recorded."""
        super().__init__()
        self.clock, self.storage = clock, storage
        self.ports = watcher
        self.before_new: BeforeNew = lambda act: act()
        """Called before what was known of the module shown is dropped, because a person says that it is another."""
        self.before_leaving: Callable[[Port, Callable[[], object]], object] = lambda _port, act: act()
        """Called before a person's wish to disconnect a port is done."""
        self._connections: list[Port] = []
        self._leaving: set[Port] = set()
        self._jobs: set[Job[Any]] = set()
        """Of the pages, on the current port."""
        self._next: Port | None = None
        self._then: Callable[[], object] | None = None
        self._settling = QTimer(self, singleShot=True, interval=SETTLE_MS)
        self._settling.timeout.connect(self._switch)
        self.invalidated.connect(self._drop_jobs)
        self.current = self.add(make_worker)
        self._relay(self.current)
        self.lock = LockControl(self)
        self._ticking = QTimer(self, interval=TICK_MS)
        self._ticking.timeout.connect(self._tick)
        self._ticking.start()

    # Several ports

    @property
    def connections(self) -> tuple[Port, ...]:
        """All ports, in the order in which they were added."""
        return tuple(self._connections)

    @property
    def is_any_active(self) -> bool:
        """A module on any open port may fire by its thresholds, as far as is known."""
        return any(port.is_open and port.is_active for port in self._connections)

    def add(self, make_worker: MakeWorker | None = None) -> Port:
        """Another port, not yet connected; the current one stays current."""

        def before_new(act: Callable[[], object]) -> None:
            """A person has edited settings of the shown module only."""
            if port is self.current:
                self.before_new(act)
            else:
                act()

        port = Port(
            self.ports, self.storage, before_new=before_new, make_worker=make_worker, clock=self.clock, parent=self
        )
        port.set_shown(is_shown=not self._connections)
        port.changed.connect(self.any_changed)
        port.lock.changed.connect(self.any_changed)
        port.module.changed.connect(partial(self._on_named, port))
        self._connections.append(port)
        self.added.emit(port)
        return port

    def remove(self, port: Port) -> None:
        """Close a port that is not current, and drop it once it is closed."""
        if port is self.current or port is self._next or port not in self._connections:
            return
        self._connections.remove(port)
        self._leaving.add(port)
        port.batch.connect(partial(self._on_removed_batch, port))
        port.disconnect_port()
        self.removed.emit(port)

    def choose(self, port: Port, *, then: Callable[[], object] | None = None) -> None:
        """Show this port's module in the pages, once their procedures on the current one have ended; `then` is called
        behind that. The current one chosen again meanwhile stays."""
        if port not in self._connections:
            return
        self._next, self._then = (port, then) if port is not self.current else (None, None)
        if self._next is None:
            return
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
        others = (port for port in self._connections if port is not self.current and port.is_requested)
        same = next((port for port in others if port.target is not None and port.target.key == target.key), None)
        if same is not None:
            self.choose(same, then=self.find_rate if target.finds_rate else None)
        else:
            self.current.connect_to(target)

    def find_rate(self) -> None:
        """As a slot: of the port that is then the current one."""
        self.current.find_rate()

    def set_drawing_interval(self, every_s: float = PUBLISH_EVERY_S) -> None:
        """How often the shown page draws the current port."""
        self.current.set_shown(is_shown=True, every_s=every_s)

    @property
    def is_busy(self) -> bool:
        """A procedure that a person started is running."""
        return bool(self._jobs) or self.current.is_checking

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

        job = self.current.run(procedure, end, is_urgent=is_urgent, on_progress=on_progress)
        if not is_urgent:
            self._jobs.add(job)
        return job

    def stop(self, deadline_s: float) -> bool:
        """Close all ports and end their workers, within `deadline_s`; whether they ended."""
        self._settling.stop()
        self._ticking.stop()
        ends_at = time.monotonic() + deadline_s
        every = [*self._connections, *self._leaving]
        for port in every if len(every) > 1 else ():
            port.disconnect_port()  # all at once; `stop` waits for one after the other
        have_ended = [port.stop(max(0.0, ends_at - time.monotonic())) for port in every]
        return all(have_ended)

    # What happens

    def _tick(self) -> None:
        self.current.update_view()  # without a batch, too
        if self.current.view.is_aging:
            self.ticked.emit()

    def _relay(self, port: Port) -> None:
        for mine, its in self._pairs(port):
            its.connect(mine)

    def _pairs(self, port: Port) -> tuple[tuple[Any, Any], ...]:
        return (
            (self.changed, port.changed),
            (self.batch, port.batch),
            (self.invalidated, port.invalidated),
            (self.disconnected, port.disconnected),
            (self.came_online, port.came_online),
            (self.stream_left_on, port.stream_left_on),
            (self.slept, port.slept),
            (self.contradicted, port.contradicted),
            (self.renamed, port.module.changed),
            (self.broke_in_doubt, port.module.broke_in_doubt),
            (self.lock_changed, port.lock.changed),
            (self.notified, port.lock.notified),
        )

    def _switch(self) -> None:
        self._settling.stop()
        before, then, (now, self._next) = self.current, self._then, (self._next, None)
        if now is None or now not in self._connections:
            return
        for mine, its in self._pairs(before):
            its.disconnect(mine)
        now.stream.is_wanted, before.stream.is_wanted = before.stream.is_wanted, False
        before.set_shown(is_shown=False)
        now.set_shown(is_shown=True)
        self.current = now
        self._show_opening(now)
        self._relay(now)
        self.batch.emit(now.last._replace(samples=(), events=(), finished=()))
        self.changed.emit()
        self.lock_changed.emit()  # while it seemed to be opening LOCK was not possible
        if now.is_open and now.device.presence is Presence.ONLINE and now.target is not None:
            self.came_online.emit(now.target)
        if then is not None:
            then()

    def _show_opening(self, port: Port) -> None:
        """Clear the pages: no value of the previous module, and nothing prepared for it, may remain."""
        with port.shown_as_opening():
            self.invalidated.emit()
            self.chosen.emit()
            self.renamed.emit()
            self.lock_changed.emit()
            self.batch.emit(port.last)
            self.changed.emit()

    def _drop_jobs(self) -> None:
        """What still runs on the former module ends soon; what it found reaches no page."""
        jobs, self._jobs = self._jobs, set()
        for job in jobs:
            job.cancel()

    def _on_named(self, port: Port) -> None:
        """The module of this name is here, so what answers on another port is not."""
        for other in self._connections:
            if other is not port and other.is_open and other.module.name == port.module.name != "":
                other.module.choose("")

    def _on_removed_batch(self, port: Port, batch: Batch) -> None:
        if batch.connection.state is PortState.CLOSED and port in self._leaving:
            self._leaving.remove(port)
            QTimer.singleShot(0, self, partial(_end, port))


def _end(port: Port) -> None:
    port.stop(0.0)
    port.deleteLater()


class LockControl:
    """What presses LOCK: on the port whose module the pages show, or on all."""

    def __init__(self, ports: Ports) -> None:
        self._ports = ports
        self.buttons: WeakSet[QWidget] = WeakSet()
        """Those that press it: a click on one counts also while a menu is open."""

    def press(self, _is_checked: bool = False, *, then: Callable[[], object] | None = None) -> None:
        self._ports.current.lock.press(then=then)

    def press_all(self, *, then: Callable[[], object] | None = None) -> None:
        """LOCK on every open port, each by itself: none waits for another. `then` is called when all of them report
        that they are locked."""
        ports = [port for port in self._ports.connections if port.lock.is_possible]
        waiting = set(ports)

        def note(port: Port) -> None:
            waiting.discard(port)
            if not waiting and then is not None:
                then()

        for port in ports:
            port.lock.press(then=partial(note, port))
