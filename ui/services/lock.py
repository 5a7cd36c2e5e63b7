"""LOCK control: one path from every button, key and menu entry, and one state shown everywhere."""

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QObject, Signal

from app.engine.device import How
from app.engine.identity import Trust
from app.engine.procedure import LockRepeat
from app.engine.worker import Batch, Job
from app.procedures.lock import Locked, lock, waiting_sentence
from app.safety.journal import Journal, Outcome
from app.safety.last_known import Activation
from app.text.i18n import tr
from ui.core.port_connection import PortConnection
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice

_SHOWN_FROM = 2
"""A LOCK that is reported after its first frame is not worth a notice."""


class PortLock(QObject):
    """LOCK on one port.

    `press` sends it at once and repeats it until the module reports that it is locked, for at most ten seconds. If
    the port is lost, it waits for the port within that time; what answers then confirms LOCK only once it is proven to
    be the same module. `failed` stays until a report says that the module is locked, or another module is connected.
    """

    changed = Signal()
    notified = Signal(str)
    """A line for the status bar."""

    def __init__(self, port: PortConnection, find_journal: Callable[[], Journal]) -> None:
        super().__init__(port)
        self._port, self._find_journal = port, find_journal
        self._repeat: LockRepeat | None = None
        """The running repetition."""
        self._job: Job[Locked] | None = None
        self._then: list[Callable[[], object]] = []
        self._adapter_key = port.adapter_key
        self._pressed_at: str | None = None
        """Key of the adapter or port that it was pressed for."""
        self._ended_at = 0.0
        self._shown_count = 0
        self._was_settled = True
        """When LOCK was pressed it was known which module it is, or it had no name."""
        self._was_lost = False
        """The port was lost since LOCK was pressed."""
        self._reported: Locked | None = None
        """What answers after that is locked, and is still being identified."""
        self.failed: Locked | None = None
        self.confirmed: Locked | None = None
        """The last confirmation; cleared when the module reports otherwise, and with each connection."""
        port.changed.connect(self._watch)
        port.batch.connect(self._on_batch)
        port.invalidated.connect(self._end_confirmed)

    @property
    def is_possible(self) -> bool:
        return self._port.is_open

    @property
    def is_repeating(self) -> bool:
        return self._repeat is not None

    @property
    def sent(self) -> int | None:
        """How often LOCK was sent in the running repetition; None if none is running."""
        return None if self._repeat is None else self._repeat.sent

    @property
    def is_reported(self) -> bool:
        """LOCK was confirmed, and the module still reports that it is locked."""
        return self.confirmed is not None and self._port.activation.state is Activation.LOCKED

    @property
    def is_unproven(self) -> bool:
        """LOCK was pressed, and the module has not reported that it is locked."""
        return self.is_repeating or self.failed is not None

    def press(self, _is_checked: bool = False, *, then: Callable[[], object] | None = None) -> None:
        """Send LOCK; pressed again, it is sent again at once and the time starts over. `then` is called when the module
        reports that it is locked."""
        if not self.is_possible:
            return
        if then is not None:
            self._then.append(then)
        self._begin()
        self._was_lost = False
        self._was_settled = self._port.identity.is_settled
        self._send(LockRepeat())
        self.notified.emit(waiting_sentence(1))
        self.changed.emit()

    def ensure_locked(self) -> None:
        """As `press`; without a port LOCK is sent once the same port is open again, as `notice` says."""
        if self.is_possible:
            self.press()
            return
        self._begin()
        self._job, self._repeat, self._was_lost = None, LockRepeat(), True
        self._watch()

    def end(self) -> None:
        """Stop repeating LOCK: the module is being activated on purpose."""
        self.failed = None
        if self._job is not None:
            self._job.cancel()
        elif self._repeat is not None:
            self._finish(Locked(outcome=Outcome.UNKNOWN, sent=self._repeat.sent, is_replaced=True))

    def notice(self, more: tuple[Choice, ...] = ()) -> Notice | None:
        """Shown until the module reports that it is locked; None if there is nothing to say."""
        repeat = self._repeat
        if repeat is not None:
            if self._shown_count < _SHOWN_FROM and self._job is not None:
                return None
            text = waiting_sentence(self._shown_count)
            if self._reported is not None:
                text = tr("Checking whether it is the same module…")
            elif self._job is None:
                text = (
                    tr("LOCK not reported; sent again when the port is back.")
                    if repeat.sent
                    else tr("LOCK not sent: treat the module as ACTIVE. Sent when the port is back.")
                )
            return Notice(Meaning.ATTENTION, text, more)
        if self.failed is None:
            return None
        if self.is_possible:
            others = (choice._replace(is_main=False) for choice in more)
            more = (Choice("lock_again", tr("LOCK again"), self.press, is_main=True), *others)
        return Notice(Meaning.DANGER, self.failed.sentence, more)

    # What happens

    @property
    def _port_key(self) -> str | None:
        return None if self._port.target is None else self._port.target.key

    def _begin(self) -> None:
        self.failed = self.confirmed = self._reported = None
        self._adapter_key, self._pressed_at, self._shown_count = self._port.adapter_key, self._port_key, 0

    def _send(self, repeat: LockRepeat) -> None:
        self._repeat = repeat
        procedure = lock(self._find_journal(), repeat)
        self._job = self._port.run(procedure, partial(self._end, repeat), is_urgent=True)

    def _end(self, repeat: LockRepeat, job: Job[Locked]) -> None:
        if repeat is not self._repeat or job is not self._job:
            return  # it was pressed again meanwhile
        self._job = None
        if job.run.error is not None:
            outcome = Outcome.UNKNOWN if repeat.sent else Outcome.NOT_SENT
            locked = Locked(outcome=outcome, sent=repeat.sent, is_port_lost=True)
        else:
            locked = job.outcome()
        if locked.is_port_lost and self._can_continue():
            self.notified.emit("")  # the notice says it from now on
            self.changed.emit()
        elif locked.is_locked and (self._was_lost or self._is_in_doubt):
            self._reported = locked
            self._identify()
            self.changed.emit()
        else:
            self._finish(locked)

    @property
    def _is_in_doubt(self) -> bool:
        """What answers now may be another module than the one that LOCK was pressed for."""
        return (self._was_lost or self._was_settled) and not self._is_meant_module

    @property
    def _is_meant_module(self) -> bool:
        """After a lost port only a person can say so, and of a module without a name nobody can."""
        identity = self._port.identity
        return identity.is_settled if not self._was_lost else identity.trust is Trust.PROVEN

    def _identify(self) -> None:
        """Take what was reported for the module that was meant, or not, once that is known."""
        identity, reported = self._port.identity, self._reported
        if reported is None:
            return
        if not self._port.is_open:
            self._reported = None
        elif self._is_meant_module:
            self._finish(reported)
        elif identity.trust is not Trust.OPEN:
            self._finish(Locked(outcome=Outcome.UNKNOWN, sent=reported.sent))

    def _finish(self, locked: Locked) -> None:
        self._repeat = self._job = self._reported = None
        self._ended_at = self._port.clock()
        then, self._then = self._then, []
        if locked.is_locked:
            self.failed, self.confirmed = None, locked
            self.notified.emit(tr("The module reports LOCKED."))
        else:
            self.failed = None if locked.is_replaced else locked
            self.notified.emit("")
        self.changed.emit()
        if locked.is_locked:
            for act in then:
                act()

    def _can_continue(self) -> bool:
        """The lost port may still come back in time."""
        repeat = self._repeat
        return self._port.is_requested and repeat is not None and repeat.is_repeating(self._port.clock())

    def _on_batch(self, batch: Batch) -> None:
        repeat = self._repeat
        if repeat is not None and repeat.sent != self._shown_count:
            self._shown_count = repeat.sent
            if repeat.sent >= _SHOWN_FROM:
                self.notified.emit("")  # the notice says it from now on
            self.changed.emit()
        if repeat is not None and self._job is None:
            self._watch()
        known = batch.device.known("active", batch.at)
        if known is None or known.is_stale or known.how is How.ACKNOWLEDGED or known.at <= self._ended_at:
            return
        if self.failed is not None and known.value is False and not self._is_in_doubt:
            self._finish(Locked(outcome=Outcome.CONFIRMED, sent=self.failed.sent))
        elif known.value is True:
            self._end_confirmed()

    def _end_confirmed(self) -> None:
        if self.confirmed is not None:
            self.confirmed = None
            self.changed.emit()

    def _watch(self) -> None:
        """React to a port that came back, was closed, or belongs to another module."""
        if self._adapter_key != self._port.adapter_key:
            self._adapter_key = self._port.adapter_key
            self.failed = self.confirmed = self._reported = None
            self._then.clear()
            if self._job is None or self._pressed_at != self._port_key:
                self._repeat = self._job = None
        self._was_lost |= self._port.is_requested and not self._port.is_open
        self._identify()
        repeat = self._repeat
        if repeat is not None and self._job is None and self._reported is None:
            if self._port.is_open and repeat.is_repeating(self._port.clock()):
                self._send(repeat)
            elif not self._can_continue():
                outcome = Outcome.UNKNOWN if repeat.sent else Outcome.NOT_SENT
                self._finish(Locked(outcome=outcome, sent=repeat.sent, is_port_lost=True))
                return
        self.changed.emit()
