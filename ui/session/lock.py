"""LOCK on one port: one path from every button, key and menu entry, and one state shown everywhere."""

from collections.abc import Callable
from typing import Final

from PySide6.QtCore import QObject, Signal

from app.engine.procedure import Job, LockRepeat
from app.engine.worker import Batch
from app.procedures.lock import OWED, Locked, lock, waiting_sentence
from app.safety.journal import Journal, Outcome
from app.safety.last_known import Activation, SeenActivation
from app.text.i18n import tr
from ui.style.theme import Meaning
from ui.widgets.notices import Choice, Notice

# A LOCK that is reported after its first frame is not worth a notice.
SHOWN_FROM: Final = 2


class PortLock(QObject):
    """`press` sends LOCK at once and repeats it until the module reports that it is locked, for at most ten seconds,
    also through the end of a conversation. What could not be sent is owed: the worker sends it first in the next
    conversation at the same adapter, within a minute. `failed` stays until a report says that the module is locked, or
    LOCK is pressed again."""

    changed = Signal()
    notified = Signal(str)  # A line for the status bar

    def __init__(
        self,
        submit: Callable[[Job[Locked], Callable[[Job[Locked]], None]], object],
        find_journal: Callable[[], Journal],
        find_number: Callable[[], int],
        *,
        parent: QObject,
    ) -> None:
        """`submit` hands an urgent job to the worker. `find_journal`, `find_number`: of the conversation that is shown,
        after which the worker may have begun another one already."""
        super().__init__(parent)
        self._submit, self._find_journal, self._find_number = submit, find_journal, find_number
        # Both of the repetition that is running.
        self._repeat: LockRepeat | None = None
        self._job: Job[Locked] | None = None
        self._then: list[Callable[[], object]] = []
        self._shown_count = 0
        self.is_possible = False
        self._activation = SeenActivation(Activation.UNKNOWN)
        # LOCK that is sent first when a module answers again, or stands because that took too long.
        self.is_owed = False
        self.failed: Locked | None = None
        # The last confirmation, until the module reports ACTIVE.
        self.confirmed: Locked | None = None

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
        return self.confirmed is not None and self._activation.state is Activation.LOCKED

    @property
    def is_unproven(self) -> bool:
        """LOCK was pressed, and no module has reported that it is locked."""
        return self.is_repeating or self.failed is not None or self.is_owed

    def press(self, _is_checked: bool = False, *, then: Callable[[], object] | None = None) -> None:
        """Send LOCK. Pressed again, it is sent again at once and the time starts over. Without an open port it is owed.
        `then` is called when the module reports that it is locked."""
        if then is not None:
            self._then.append(then)
        self.failed = self.confirmed = None
        self._shown_count = 0
        self._repeat = repeat = LockRepeat()
        pressed_in = self._find_number() or None
        self._job = Job(lock(self._find_journal(), repeat, pressed_in=pressed_in), conversation=None)
        self._submit(self._job, self._end)
        if self.is_possible:
            self.notified.emit(waiting_sentence(1))
        self.changed.emit()

    def make_owed(self) -> Job[Locked]:
        """The job of an owed LOCK, for the worker and in its thread."""
        return Job(lock(self._find_journal(), pressed_in=OWED), conversation=None)

    def give_up(self) -> None:
        """Stop repeating LOCK: the module is being activated on purpose, and what was confirmed before says nothing."""
        self.failed = self.confirmed = None
        if self._job is not None:
            self._job.cancel()

    def notice(self) -> Notice | None:
        """Shown until the module reports that it is locked; None if there is nothing to say."""
        if self.is_repeating:
            is_shown = self._shown_count >= SHOWN_FROM
            text = waiting_sentence(self._shown_count)
            return Notice(Meaning.ATTENTION, text, cause="lock") if is_shown else None
        if self.is_owed:
            text = tr("LOCK not confirmed: treat the module as ACTIVE. Sent when it answers.")
            return Notice(Meaning.DANGER, text, cause="lock")
        if self.failed is None:
            return None
        again = (Choice("lock_again", tr("LOCK again"), self.press, is_main=True),) if self.is_possible else ()
        return Notice(Meaning.DANGER, self.failed.sentence, again, cause="lock")

    def take_in(self, batch: Batch, activation: SeenActivation, *, is_open: bool) -> None:
        """What its port tells."""
        before = (self.is_possible, self.is_owed, self._shown_count, self._activation.state)
        self.is_possible, self.is_owed, self._activation = is_open, batch.is_lock_owed, activation
        if self._repeat is not None and self._repeat.sent != self._shown_count:
            self._shown_count = self._repeat.sent
            if self._shown_count >= SHOWN_FROM:
                self.notified.emit("")  # the notice says it from now on
        if activation.state is Activation.ACTIVE:
            if self.confirmed is not None:
                self.notified.emit("")  # that it reports LOCKED is no longer true
            self.confirmed = None
        elif activation.state is Activation.LOCKED and not self.is_repeating:
            self.failed = None
        if before != (self.is_possible, self.is_owed, self._shown_count, self._activation.state):
            self.changed.emit()

    def _end(self, job: Job[Locked]) -> None:
        if job is not self._job:
            return  # it was pressed again meanwhile
        sent, then = self.sent or 0, self._then
        self._repeat, self._job, self._then = None, None, []
        if job.error is not None:
            outcome = Outcome.UNKNOWN if sent else Outcome.NOT_SENT
            locked = Locked(outcome=outcome, sent=sent, is_port_lost=True)
        else:
            locked = job.outcome()
        if locked.is_locked:
            self.confirmed = locked
        else:
            self.failed = None if locked.is_replaced else locked
        self.notified.emit(locked.sentence if locked.is_locked else "")
        self.changed.emit()
        if locked.is_locked:
            for act in then:
                act()
