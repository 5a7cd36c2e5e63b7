"""The link of one port as the window sees it: target, state, reconnection."""

import logging
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from app.diagnosis.link_state import LinkState, link_state
from app.engine.device import DeviceView
from app.engine.identity import NO_EXPECTATION, UNKNOWN, Expected, Identity, IdentityEvidence, Trust, evidence_of
from app.engine.ports import PortInfo
from app.engine.procedure import Procedure, Report, Result, Slept, contradiction
from app.engine.reconnect import Address, Reconnection
from app.engine.target import Target
from app.engine.transport import PortError
from app.engine.worker import PUBLISH_EVERY_S, Batch, Connection, Job, PortState, Worker
from app.procedures.find import RateSearch, find_rate
from app.procedures.handshake import Silence, handshake
from app.procedures.light_calibration import LightDirection
from app.procedures.stream import StreamSwitch, watch
from app.safety.last_known import LastKnown, SeenActivation
from app.store.stream_memory import StreamMemory
from protocol.link_states import Presence
from ui.core.bridge import Bridge
from ui.core.module_memory import VIEWED, ModuleMemory, PortView
from ui.core.port_watcher import PortWatcher

_log = logging.getLogger(__name__)
MakeWorker = Callable[[Callable[[Batch], None]], Worker]
MIN_PUBLISH_EVERY_S = 1 / 30
UNSEEN_PUBLISH_EVERY_S = 0.25
FOLLOW_EVERY_MS = 100  # while a port is waited for: how often it is checked


class PortConnection(QObject):
    """Owns a worker. Reconnects by itself after a loss, by the rules of `app.engine.reconnect`."""

    changed = Signal()
    """`view` is another one."""
    batch = Signal(object)
    """Each `Batch`, after the state was updated from it."""
    invalidated = Signal()
    """What was known is of another connection or another module from now on: whoever holds anything of it drops it.
    Comes before anything of the next one, its name included."""
    disconnected = Signal()
    """By a person."""
    came_online = Signal(object)
    """The `Target`, whenever a module answers on it."""
    stream_left_on = Signal()
    """The serial output had been left on and will be switched off; once for each `connect_to`."""
    contradicted = Signal(object)
    """One question was answered twice and differently, as this `UserMessage` says: two modules on this line?"""
    slept = Signal(float)
    """The computer slept for this many seconds while the port was open; values read before are no longer valid."""

    def __init__(
        self,
        ports: PortWatcher,
        memory_of: Callable[[Target], StreamMemory],
        *,
        make_worker: MakeWorker,
        clock: Callable[[], float],
        parent: QObject,
    ) -> None:
        """`memory_of` returns where it is stored that the serial output was switched on."""
        super().__init__(parent)
        self.clock = clock
        self.stream = StreamSwitch(is_wanted=False)
        self._memory_of = memory_of
        self.bridge = Bridge(self)
        self.bridge.batch.connect(self._on_batch)
        self._worker = make_worker(self.bridge.deliver)
        self._ports = ports
        self._ports.listed.connect(self._on_ports)
        self.target: Target | None = None
        self.last = Batch(clock(), Connection(), DeviceView(), None)
        self._silence: Silence | None = None
        self._endings: dict[Job[Any], Callable[[Job[Any]], None]] = {}
        self._finding: Job[RateSearch] | None = None
        self._last_known = LastKnown()
        self.kept = ModuleMemory()
        self._opening = 0  # batches of earlier openings of the port are ignored
        self.adapter_key = ""
        """Key of the connected adapter or port; unchanged when it returns under another name."""
        self._return = Reconnection()
        self._is_listing = False
        """A scan of the ports is running for `_return`, and its result is still wanted."""
        self.stream_memory = StreamMemory()  # of the connection that was opened last
        self._is_left_on_emitted = False
        self._lost = NO_EXPECTATION
        """Identity of the module on the lost port; `now` holds what was last read of it where it was proven."""
        self._trouble: PortError | None = None
        """The last error; shown until the port is open again."""
        self._looked: tuple[tuple[int, int] | None, Counter[bytes]] = None, Counter()
        self._light: tuple[tuple[int, int] | None, LightDirection | None] = None, None
        self.view = self._derive_view()
        self._follow_up = QTimer(self, interval=FOLLOW_EVERY_MS)
        self._follow_up.timeout.connect(self._poll_absence)
        self._worker.start()

    # What is known

    @property
    def identity(self) -> Identity:
        """Whether this is the expected module; until that is proven only queries are sent. Nobody is asked while none
        answers."""
        if self.connection.state is PortState.OPENING:
            return Identity(Trust.OPEN)
        identity = self.last.identity if self.is_open else NO_EXPECTATION
        is_silent = identity.is_for_a_person and self.device.presence is Presence.OFFLINE
        return identity._replace(trust=Trust.OPEN) if is_silent else identity

    @property
    def device(self) -> DeviceView:
        return self.last.device

    @property
    def connection(self) -> Connection:
        return self.last.connection

    @property
    def conversation(self) -> tuple[int, int]:
        """Another one once another module may answer."""
        return self.connection.opening, self.device.breaks

    @property
    def light_direction(self) -> LightDirection | None:
        """Which way the light reads in this conversation; None until it was measured with the bay closed and open
        (E11)."""
        conversation, direction = self._light
        return direction if conversation == self.conversation else None

    def keep_light_direction(self, direction: LightDirection) -> None:
        self._light = self.conversation, direction

    @property
    def looked_at(self) -> Counter[bytes]:
        """The trigger records that a person had before them in this conversation, as raw bytes."""
        conversation, records = self._looked
        return records if conversation == self.conversation else Counter()

    def keep_looked_at(self, records: Iterable[bytes]) -> None:
        self._looked = self.conversation, self.looked_at | Counter(records)

    @property
    def is_open(self) -> bool:
        return self.connection.state is PortState.OPEN

    @property
    def is_requested(self) -> bool:
        """A connection is wanted, whether or not the port is open."""
        return self._return.address is not None

    @property
    def state(self) -> LinkState:
        connection = self.connection
        if self._is_returning:
            connection = connection._replace(trouble=self._trouble)
        elif not self.is_requested and connection.state is PortState.CLOSED:
            connection = connection._replace(trouble=None)  # that port is no longer wanted
        return link_state(
            connection, self.device, self._silence, is_finding=self._finding is not None,
            absence=self._return.absence, switched_off_at=self._last_known.switched_off_at, was_active=self.is_active,
        )  # fmt: skip

    @property
    def _is_returning(self) -> bool:
        return self._return.absence is not None and self._return.absence.is_waiting

    @property
    def is_active(self) -> bool:
        """The module may fire by its thresholds. A stale "active" counts as active."""
        return self.activation.may_fire

    @property
    def activation(self) -> SeenActivation:
        return self._last_known.activation(self.device, self.clock())

    def note_shutdown(self) -> None:
        """The module acknowledged the shut-down: its silence is no fault until it answers again."""
        self._last_known.note_shutdown(self.clock(), time.time())
        self.update_view()

    def update_view(self) -> None:
        """Of what is known now; time alone makes values stale."""
        view = self._derive_view()
        if view != self.view:
            self.view = view
            self.changed.emit()

    # What can be done

    def connect_to(self, target: Target) -> None:
        """Open `target`; an open port is closed first."""
        self._is_left_on_emitted = self._is_listing = False
        is_adapter_same = self.target is not None and target.key == self.target.key
        self.adapter_key = target.key
        self._return.request(Address(target.device, target.identity))
        self.target = target
        self._forget(Connection(PortState.OPENING, target.device, target.baud_rate), is_adapter_same=is_adapter_same)
        self._open(target, self.expected_at(target))

    def disconnect_port(self) -> None:
        if self.connection.state is PortState.OPENING:
            self.last = self.last._replace(connection=self.connection._replace(state=PortState.CLOSED))
        was_requested, self._is_listing = self.is_requested, False
        self._return.give_up()
        self._worker.close()
        self.update_view()
        if was_requested:
            self.disconnected.emit()

    def set_shown(self, *, is_shown: bool, every_s: float = PUBLISH_EVERY_S) -> None:
        """Whether the pages show this port; else it publishes less often. `every_s`: what a moving picture needs."""
        seen_s = min(PUBLISH_EVERY_S, max(MIN_PUBLISH_EVERY_S, every_s))
        self._worker.publish_every_s = seen_s if is_shown else UNSEEN_PUBLISH_EVERY_S

    def find_rate(self) -> None:
        if self._finding is not None or not self.is_open:
            return
        self._finding = self.run(find_rate(self.connection.baud_rate), self._end_finding)

    def confirm_identity(
        self, seen: Identity | None = None, *, is_named: bool | None = None, before: IdentityEvidence = UNKNOWN
    ) -> None:
        """A person says which module this is, see `IdentityCheck.confirm`; `seen` is what was shown to them."""
        self._worker.confirm_identity(seen, is_named=is_named, before=before)

    def treat_as_new(self, *, is_named: bool = False, before: IdentityEvidence = UNKNOWN) -> None:
        """A person says that this is another module: what was known of the first one is dropped, and what is still
        under way of it ignored."""
        number = self._worker.treat_as_new(is_named=is_named, before=before)
        if self.target is not None:
            self.target = self.target._replace(baud_rate=self.connection.baud_rate)  # it answers at this one
        self.adapter_key = f"{'' if self.target is None else self.target.key}#{number}"
        self._forget(self.connection._replace(opening=number))
        self._opening = number
        self.update_view()

    def expect_next(self, before: IdentityEvidence) -> None:
        """A person names the module that is plugged in next, while the port is lost; a LOCK that waits goes on."""
        self._forget(self.connection, is_adapter_same=True)
        self._lost = Identity(Trust.OPEN, before, is_named=True)

    def run(
        self,
        procedure: Procedure[Result],
        then: Callable[[Job[Result]], None],
        *,
        is_urgent: bool = False,
        on_progress: Callable[[Report], None] | None = None,
    ) -> Job[Result]:
        """Hand a procedure to the worker; `then` is called in the window's thread when it has ended, `on_progress`
        in the worker's: it may only remember what it is given. See `Session.run`."""
        job = Job(procedure, on_progress)
        self._endings[job] = then
        return self._worker.submit(job, is_urgent=is_urgent)

    def stop(self, deadline_s: float) -> bool:
        """Close the port and end the worker, within `deadline_s`; whether it ended."""
        self._return.give_up()
        self._follow_up.stop()
        self.bridge.close()
        return self._worker.stop(deadline_s)

    @contextmanager
    def shown_as_opening(self) -> Iterator[None]:
        """For pages that begin to show the port: it seems to be just opened, with nothing known."""
        known, at = (self.last, self._last_known), self.connection
        self.last = Batch(self.last.at, Connection(PortState.OPENING, at.port, at.baud_rate), DeviceView(), None)
        self._last_known = LastKnown()
        try:
            yield
        finally:
            self.last, self._last_known = known

    # What happens

    def expected_at(self, _target: Target) -> Expected | None:
        """What was last read of the module known there; called before the port is opened."""
        return None

    def _derive_view(self) -> PortView:
        device, known = self.device, (self.device.known(key, self.clock()) for key in VIEWED)
        values = tuple(None if value is None else (value.value, value.is_stale) for value in known)
        return PortView(
            self.state, self.identity, self.activation.state, self.is_requested, self._opening, device.restarts, values
        )

    def _forget(self, connection: Connection, *, is_adapter_same: bool = False) -> None:
        """Nothing of the last module, nor of what is still under way from it, is taken for the next one's; only that it
        may fire is not forgotten at the same adapter."""
        if not is_adapter_same:
            self._last_known.clear()
        self._opening += 1
        self.last = Batch(self.clock(), connection, DeviceView(), None)
        self.kept = ModuleMemory()
        self.invalidated.emit()

    def _open(self, target: Target, expected: Expected | None) -> None:
        self.target = target
        self._silence = self._finding = None
        self.stream_memory = self._memory_of(target)
        background = partial(watch, self.stream, memory=self.stream_memory)
        device, rate, is_another = target.device, target.baud_rate, not self.device.values
        self._opening = self._worker.open(device, rate, background, is_another, expected, is_attended=True)
        self.last = self.last._replace(connection=Connection(PortState.OPENING, device, rate, opening=self._opening))
        _log.info("Port: %s", self.connection)
        if target.finds_rate:
            self._finding = self.run(find_rate(target.baud_rate), self._end_finding)
        else:
            self._ask()
        self.update_view()

    def _on_batch(self, batch: Batch) -> None:
        if batch.connection.opening < self._opening:
            self._end_jobs(batch)
            return
        if self.stream_memory.is_taken_over and not self._is_left_on_emitted:
            self._is_left_on_emitted = True
            self.stream_left_on.emit()
        last, was_online = self.last, self._is_online()
        is_news = batch.connection != last.connection
        if is_news:
            _log.info("Port: %s", batch.connection)
        self.last = batch
        self._last_known.feed(self.device)
        self.kept.statistics.on_batch(batch)
        self.kept.watch.note_writes(batch.events)
        self._end_jobs(batch)
        if is_news:
            self._on_connection(batch.connection)
        if self._is_online() and not was_online and self.target is not None:
            self.came_online.emit(self.target)
        sleep = batch.device.last_sleep
        if sleep is not None and sleep != last.device.last_sleep:
            _log.info("The computer slept for %.0f s", sleep.lasted_s)
            self.slept.emit(sleep.lasted_s)
        contradicted = batch.device.contradicted
        if contradicted is not None and contradicted != last.device.contradicted:
            self.contradicted.emit(contradiction(contradicted))
        self.batch.emit(batch)
        self.update_view()

    def _end_jobs(self, batch: Batch) -> None:
        for job in batch.finished:
            then = self._endings.pop(job, None)
            if then is not None:
                then(job)

    def _is_online(self) -> bool:
        return self.is_open and self.device.presence is Presence.ONLINE

    # Coming back

    def _on_connection(self, connection: Connection) -> None:
        self._trouble = connection.trouble or self._trouble
        address = self._return.address
        if address is None or connection.port != address.device:
            return  # of a port that was closed meanwhile
        self._is_listing = False
        if connection.trouble is not None:
            self._lost = lost = self.last.identity
            if lost.is_settled:
                self._lost = lost._replace(now=evidence_of(self.last.device.values, is_fresh=False))
        self._return.feed(connection, self.clock())
        if self._return.absence is not None or connection.state is PortState.OPEN:
            self._follow_up.start()

    def _poll_absence(self) -> None:
        """Scan the ports when `Reconnection` needs them."""
        is_due = self._return.is_due(self.clock())
        if not self._is_returning and not is_due:
            self._follow_up.stop()
        elif is_due and not self._is_listing and self.connection.state is not PortState.OPENING:
            if self._return.needs_ports:
                self._is_listing = self._ports.refresh()  # a scan that is running may have begun before the loss
            else:
                self._reopen(())

    def _on_ports(self) -> None:
        is_ours, self._is_listing = self._is_listing, False
        if is_ours and self._ports.is_current:
            self._reopen(self._ports.ports)

    def _reopen(self, ports: tuple[PortInfo, ...]) -> None:
        target = self.target
        port = self._return.poll(ports, self.clock())
        if port is not None and target is not None:
            expected, answered_at = self._return.expected(self._lost), self.device.values.get("baud_rate")
            rate = target.baud_rate if answered_at is None else int(answered_at.value)
            self._open(target._replace(device=port.device, baud_rate=rate), expected)
        elif self._return.is_mistaken:
            self._close_mistaken()
        else:
            self.update_view()

    def _close_mistaken(self) -> None:
        _log.warning("Another adapter is at %s: closed", self.connection.port)
        self._worker.close()
        self._follow_up.start()
        closed = self.connection._replace(state=PortState.CLOSED)
        self._return.feed(closed, self.clock())
        self._forget(closed)
        self.update_view()

    def _ask(self) -> None:
        """Who is there?"""
        opening = self._opening

        def end(job: Job[Silence | None]) -> None:
            if opening == self._opening and job.run.error is None:
                self._silence = job.outcome()

        self.run(handshake(), end)

    def _end_finding(self, job: Job[RateSearch]) -> None:
        if job is not self._finding:
            return  # of a port that was closed meanwhile
        self._finding = None
        if isinstance(job.run.error, Slept) or (job.run.error is None and job.outcome().baud_rate is None):
            _log.info("No module was found at any baud rate: %s", job.run.error or job.outcome().tried)
            self._ask()  # says what is on the line instead
