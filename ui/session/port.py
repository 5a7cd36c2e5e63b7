"""One port: what is connected there, how it comes back after a loss, LOCK, its recording, and the module that it shows.
Widgets use this, never the worker."""

import logging
import time
from collections.abc import Callable
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Any, Final

from PySide6.QtCore import QObject, QTimer, Signal

from app.diagnosis.causes import PortEvidence
from app.diagnosis.link_state import LinkState, link_state
from app.engine.conversation import ConversationView, reason_message
from app.engine.ports import PortInfo
from app.engine.procedure import Job
from app.engine.reconnect import Reconnection
from app.engine.target import Target
from app.engine.transport import PortError
from app.engine.worker import PUBLISH_EVERY_S, Batch, Connection, PortState, Worker
from app.procedures.act import Armed
from app.procedures.find import RateSearch, find_rate
from app.procedures.stream import StreamSwitch, watch
from app.safety.journal import Act
from app.safety.last_known import Activation
from app.safety.left_active import FiringDoubt
from app.safety.permit import Origin, Permit
from app.system.clock import steady_time
from app.text.messages import message
from protocol.events import EndReason
from protocol.translatable import marked
from ui.core.bridge import Bridge
from ui.core.port_watcher import PortWatcher
from ui.services.storage import Storage
from ui.session.lock import PortLock
from ui.session.recording import SessionRecording
from ui.session.sharing import PortSharing
from ui.session.shown_module import Interruptions, Remainder, ShownModule

if TYPE_CHECKING:
    from app.procedures.write import WriteReport

_log = logging.getLogger(__name__)
MIN_PUBLISH_EVERY_S: Final = 1 / 30
UNSEEN_PUBLISH_EVERY_S: Final = 0.25
# The link asks the boot count once a second, so that it may be told of a restart as late as this.
RESTART_TOLD_S: Final = 3.0
# While a port is waited for: how often it is checked.
FOLLOW_EVERY_MS = 100
# What every page shows, so that a change of it is news to all.
VIEWED: Final = (
    "triggered",
    "active",
    "attitude_trigger",
    "freefall_trigger",
    "cell_voltage_v",
    "charging",
    "boot_count",
)


class Port(QObject):
    """Owns a worker. Reconnects by itself after a loss, by the rules of `app.engine.reconnect`."""

    changed = Signal()  # Something that every page shows of it is otherwise, but for what ticks
    batch = Signal(object)  # Each `Batch`, after everything here was updated from it
    module_changed = Signal()  # `module` is another one: another conversation has begun, or another port was opened
    named = Signal()  # A person said the name of its module, or took it back

    def __init__(
        self,
        watcher: PortWatcher,
        storage: Storage,
        *,
        clock: Callable[[], float] = steady_time,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._clock, self._storage, self._watcher = clock, storage, watcher
        self.stream = StreamSwitch(is_wanted=False)
        self.recording = SessionRecording(self.stream, lambda: storage.library)
        storage.recorded.append(self.recording)
        self.lock = PortLock(
            partial(self.submit, is_urgent=True),
            lambda: self.module.journal,
            lambda: self.module.number,
            parent=self,
        )
        # What stays of the conversations that ended here.
        self.interruptions = Interruptions(self)
        # Whether a module may have fired before it restarted, by the key of its adapter.
        self._firing_doubts: dict[str, FiringDoubt] = {}
        # When the module last reported ACTIVE; long ago where LOCK was confirmed since.
        self._active_at = -inf
        self.target: Target | None = None
        # Of the adapter or the port, as it was connected; the same when it comes back under another name.
        self.key = ""
        self.connection = Connection()
        self.module = ShownModule(self, storage, ConversationView(), parent=self)
        # The name of the last conversation that had one: the window asks for it again.
        self.last_name = ""
        # When the module acknowledged the shut-down, in seconds since 1970, until a module answers again.
        self.switched_off_at: float | None = None
        # Batches of earlier openings are ignored, and conversations up to this one were with what was connected before.
        self._opening = self._former_number = 0
        self._endings: dict[Job[Any], Callable[[Job[Any]], None]] = {}
        # Since the port was opened.
        self.evidence = PortEvidence()
        self._finding: Job[RateSearch] | None = None
        self._changing_rate: Job[WriteReport] | None = None
        self._return = Reconnection()
        # A scan of the ports is running for `_return`, and its result is still wanted.
        self._is_listing = False
        # The last error; shown until the port is open again.
        self._trouble: PortError | None = None
        self.bridge = Bridge(self)
        self.bridge.batch.connect(self._on_batch)
        self._worker = Worker(self.recording.recorded(self.bridge.deliver), make_lock=self.lock.make_owed)
        self.sharing = PortSharing(self)
        self._shown: object = None
        self.is_aging = False  # It is shown with an age that ticks
        self.update_view()
        self._watcher.listed.connect(self._on_ports)
        self._follow_up = QTimer(self, interval=FOLLOW_EVERY_MS)
        self._follow_up.timeout.connect(self._poll_absence)
        self._worker.start()

    # What is known

    @property
    def now_s(self) -> float:
        """The time by the clock of the engine."""
        return self._clock()

    @property
    def firing_doubt(self) -> FiringDoubt:
        """Whether the module at this adapter may have fired before it restarted."""
        return self._firing_doubts.setdefault(self.key, FiringDoubt())

    @property
    def is_changing_rate(self) -> bool:
        return self._changing_rate is not None

    @property
    def is_open(self) -> bool:
        return self.connection.state is PortState.OPEN

    @property
    def is_requested(self) -> bool:
        """A connection is wanted, whether or not the port is open."""
        return self._return.target is not None

    @property
    def is_active(self) -> bool:
        """The module may fire by its thresholds. A stale "active" counts as active."""
        return self.is_requested and self.module.activation.may_fire

    @property
    def trouble(self) -> PortError | None:
        """Why the port that is wanted is not open; between two attempts to reconnect, what lost it."""
        if self._return.absence is not None:
            return self._trouble
        return self.connection.trouble if self.is_requested else None

    @property
    def state(self) -> LinkState:
        # A change of the rate that the module does not answer searches for it, too: until all rates were tried, nothing
        # is wrong with its power or its cable.
        is_searching = self.is_changing_rate and not self.module.is_going
        return link_state(
            self.connection._replace(trouble=self.trouble),
            self.module.view,
            self.evidence.came(),
            is_finding=self._finding is not None or is_searching,
            absence=self._return.absence,
            adapter="" if self.target is None else self.target.identity,
            switched_off_at=self.switched_off_at,
            was_active=self.is_active,
        )

    def update_view(self) -> None:
        """Tells what is otherwise now; time alone makes values stale."""
        module, state = self.module, self.state
        values = [module.view.known(key, self.now_s) for key in VIEWED]
        activation = module.activation.state
        shown = (
            (state, self.connection.port, self.connection.baud_rate),
            module.number,
            module.is_going,
            module.is_read,
            (module.name, module.doubted_name, self.last_name),
            activation,
            module.may_have_fired,
            self.is_requested,
            self.recording.state,
            [None if known is None else (known.value, known.is_stale) for known in values],
        )
        is_past = activation in (Activation.WAS_ACTIVE, Activation.WAS_LOCKED)
        is_stale = any(known is not None and known.is_stale for known in values)
        self.is_aging = is_past or is_stale or not state.is_fine
        if shown != self._shown:
            self._shown = shown
            self.changed.emit()
            module.changed.emit()

    # What can be done

    def connect_to(self, target: Target) -> None:
        """Open `target`; an open port is closed first."""
        self._is_listing = False
        if target.key != self.key:
            self.last_name = ""
            self.switched_off_at = None
        self.key = target.key
        self._return.request(target)
        self._former_number = max(self._former_number, self.module.number)
        self._show(ConversationView())
        self._open(target)

    def disconnect_port(self) -> None:
        self._is_listing = False
        self._return.request(None)
        self._worker.close()
        self.update_view()

    def treat_as_another(self) -> None:
        """A person says that another module is connected: its conversation ends, and the next one begins."""
        self.last_name = ""
        self._worker.treat_as_another()

    def find_rate(self) -> None:
        if self._finding is None and self.is_open:
            self._begin_finding(self.connection.baud_rate)
            self.update_view()

    def change_rate(self, rate: int, armed: Armed) -> None:
        """A person confirmed a moment ago that the module is to change its baud rate. It cannot be cancelled: the
        module would be lost."""
        from app.procedures.write import WriteFault, WriteReport, change_baud, why_not_verified
        from app.settings.values import value_message

        if self._changing_rate is not None:
            return
        module, name = self.module, self.module.name
        permit = Permit(Act.CHANGE_BAUD, Origin.CONFIRMATION, self.now_s, module.number)

        def end(job: Job[WriteReport]) -> None:
            """The conversation at the old rate has ended, so that what came of it stays with the port."""
            self._changing_rate = None
            report = WriteReport(results=()) if job.error is not None else job.outcome()
            text = message(marked("Nothing was sent."))
            if permit.is_spent:
                text = message(marked("Interrupted: maybe at {rate} baud now."), rate=rate)
            for written in report.results:
                if written.fault is not WriteFault.INTERRUPTED:
                    what = why_not_verified(written, report) or value_message(written.command, rate)
                    text = message(marked("{name}: {value}"), name=message(written.command.title), value=what)
            self.interruptions.keep(Remainder(name, text))

        change = change_baud(rate, module.journal, permit=permit, armed=armed)
        self._changing_rate = Job(change, conversation=None)
        self.submit(self._changing_rate, end)

    def submit(self, job: Job[Any], then: Callable[[Job[Any]], None], *, is_urgent: bool = False) -> Job[Any]:
        """Hand a job to the worker; `then` is called in the window's thread when it has ended. What a module does is
        begun with `ShownModule.run`."""
        self._endings[job] = then
        return self._worker.submit(job, is_urgent=is_urgent)

    def set_recorded(self, is_on: bool) -> None:
        """A person switches the recording on or off, for as long as the program runs."""
        self.recording.is_on = is_on
        self.update_view()

    def set_shown(self, *, is_shown: bool, every_s: float = PUBLISH_EVERY_S) -> None:
        """Whether the pages show this port; else it publishes less often. `every_s`: what a moving picture needs."""
        seen_s = min(PUBLISH_EVERY_S, max(MIN_PUBLISH_EVERY_S, every_s))
        self._worker.publish_every_s = seen_s if is_shown else UNSEEN_PUBLISH_EVERY_S

    def note_shutdown(self) -> None:
        """The module acknowledged the shut-down: its silence is no fault until one answers again."""
        self.switched_off_at = time.time()
        self.update_view()

    def stop(self, deadline_s: float) -> bool:
        """Close the port and end the worker, within `deadline_s`; whether it ended."""
        self._return.request(None)
        self._follow_up.stop()
        self.sharing.stop()
        self.bridge.close()
        return self._worker.stop(deadline_s)

    # What happens

    def _open(self, target: Target) -> None:
        self.target = target
        self._finding = None
        self.evidence = PortEvidence(target.device)
        background = partial(watch, self.stream, memory=self._storage.stream_memory(target))
        self._opening = self._worker.open(target.device, target.baud_rate, background, adapter=self.key)
        self.connection = Connection(PortState.OPENING, target.device, target.baud_rate, opening=self._opening)
        _log.info("Port: %s", self.connection)
        if target.finds_rate:
            self._begin_finding(target.baud_rate)
        self.update_view()

    def _begin_finding(self, rate: int) -> None:
        def end(job: Job[RateSearch]) -> None:
            if job is not self._finding:
                return  # of a port that was closed meanwhile
            self._finding = None
            if job.error is None and job.outcome().baud_rate is None:
                _log.info("No module was found at any baud rate: %s", job.outcome().tried)

        self._finding = Job(find_rate(rate), conversation=None)
        self.submit(self._finding, end)

    def _on_batch(self, batch: Batch) -> None:
        is_current = batch.connection.opening >= self._opening
        if is_current:
            self._take_in(batch)
        for job in batch.finished:
            then = self._endings.pop(job, None)
            if then is not None:
                then(job)
        if is_current:
            self.batch.emit(batch)
            self.update_view()

    def _take_in(self, batch: Batch) -> None:
        is_news = batch.connection != self.connection
        self.connection = batch.connection
        self.evidence = self.evidence.after(batch)
        view = batch.conversation
        if view.number > max(self._former_number, self.module.number):
            self._show(view)
        module, was_going = self.module, self.module.is_going or view.is_going
        if view.number != module.number:  # of what was connected before; the bytes on the line are of now
            module.take_in(batch._replace(conversation=module.view))
        else:
            module.take_in(batch)
        if view.ended is not None and was_going:
            _log.info("Conversation %d ended: %s", view.number, view.ended.reason.name)
            self.firing_doubt.note_ended(view, was_active=self.now_s - self._active_at < RESTART_TOLD_S)
            if view.ended.reason is not EndReason.ANOTHER:  # a person has said that it is not the one of this name
                self.last_name = module.name or self.last_name
            if module.end is not None:
                self.interruptions.note(module.end.reason, reason_message(module.end.reason, module.end.contradiction))
            if module.was_triggered:
                self.interruptions.keep(Remainder(module.name))
        self.lock.take_in(batch, module.activation, is_open=self.is_open)
        if self.lock.confirmed is not None:
            self._active_at = -inf
        elif module.activation.state is Activation.ACTIVE:
            self._active_at = self.now_s
        if not is_news:
            return
        _log.info("Port: %s", batch.connection)
        connection, requested = batch.connection, self._return.target
        self._trouble = connection.trouble or self._trouble
        if requested is not None and connection.port == requested.device:  # else of a port that was closed meanwhile
            self._is_listing = False
            self._return.feed(connection, self.now_s)
            if self._return.absence is not None or self.is_open:
                self._follow_up.start()

    def _show(self, view: ConversationView) -> None:
        """Another conversation: nothing of the module before is left."""
        former = self.module
        if former.check is not None:
            former.check.drop()
        self.module = ShownModule(self, self._storage, view, parent=self)
        self.module.named.connect(self._on_named)
        if view.is_going:
            self.switched_off_at = None
            self.firing_doubt.note_begun(view)
        self.module_changed.emit()
        former.deleteLater()

    def _on_named(self) -> None:
        self.last_name = self.module.name
        self.recording.name_module(self.module.name, self.module.view)
        self.named.emit()

    # Coming back

    def _poll_absence(self) -> None:
        """Scan the ports when `Reconnection` needs them."""
        is_due = self._return.is_due(self.now_s)
        if not self._return.is_waiting and not is_due:
            self._follow_up.stop()
        elif is_due and not self._is_listing and self.connection.state is not PortState.OPENING:
            if self._return.needs_ports:
                self._is_listing = self._watcher.refresh()  # a scan that is running may have begun before the loss
            else:
                self._reopen(())

    def _on_ports(self) -> None:
        is_ours, self._is_listing = self._is_listing, False
        if is_ours and self._watcher.is_current:
            self._reopen(self._watcher.ports)

    def _reopen(self, ports: tuple[PortInfo, ...]) -> None:
        target, device = self.target, self._return.poll(ports, self.now_s)
        if device is None or target is None:
            self.update_view()
            return
        rate = self.connection.baud_rate or target.baud_rate  # the module answered at this one
        self._open(target._replace(device=device, baud_rate=rate, finds_rate=False))
