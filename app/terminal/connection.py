"""The open port of one command, the conversation on it, and the jobs that run in it.

The worker's thread owns the port; the main thread waits for it, at most a tenth of a second at a time, so that Ctrl-C
is handled. The port is always closed properly.

A job ends with its conversation: `run` raises `Interrupted` then, whose sentence says why.
"""

import logging
import queue
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, Final, TypeVar

from app.engine import ports as serial_ports
from app.engine.conversation import ConversationView, Interrupted
from app.engine.procedure import SHARED, Job, Procedure
from app.engine.reconnect import Reconnection
from app.engine.target import Target, is_shared
from app.engine.transport import PortError
from app.engine.worker import Batch, Connection, PortState, Worker
from app.procedures.find import WAIT_S as MODULE_LIMIT_S
from app.procedures.find import find_rate
from app.safety.last_known import LAST_HEARD_ACTIVE, keep_away, was_heard_active
from app.system.clock import steady_time
from app.terminal.console import USUAL_RATE, Refused, check_signals, note, notify, state
from app.text.i18n import tr
from app.text.messages import ErrorCode, UserError, join_sentences
from protocol.events import Counters, EndReason, Sent

if TYPE_CHECKING:
    from app.diagnosis.causes import PortEvidence
    from app.procedures.lock import Locked
    from app.safety.journal import Journal

_log = logging.getLogger(__name__)
OPENING_LIMIT_S: Final = 2.0
# How long the command line waits for the module that it owes LOCK.
OWED_LIMIT_S: Final = 10.0
STOP_LIMIT_S: Final = 1.0
UNDO_LIMIT_S: Final = 0.8  # of that: three times "stream off"
WAIT_S: Final = 0.1

Result = TypeVar("Result")
Background = Callable[[], Procedure[None]] | None


class NoLink(Refused):
    """No module answers."""

    def __init__(self, sentence: str, **told: str) -> None:
        super().__init__(sentence, ErrorCode.NO_LINK, **told)


# What ends a conversation, or keeps it from beginning.
LOST: Final = (PortError, NoLink, Interrupted)


def listed_ports() -> list[serial_ports.PortInfo]:
    """Return none where they cannot be listed."""
    try:
        return serial_ports.list_ports()
    except UserError:
        return []


def adapter_of(port: str) -> str:
    """The USB identity of the adapter; "" if it has none or the ports cannot be listed."""
    found = serial_ports.port_named(port, listed_ports())
    return "" if found is None else found.identity


class OpenPort:
    """The open port, made by `connected`. One thread uses it, in which the listeners are called with all batches, in
    order."""

    def __init__(self, on_batch: Callable[[Batch], None] | None, journal: "Journal | None") -> None:
        """`journal`: of a command that activates, and so may owe LOCK."""
        self.listeners = [] if on_batch is None else [on_batch]
        if state.verbosity > 0:
            self.listeners.append(_trace())
        self._batches: queue.SimpleQueue[Batch] = queue.SimpleQueue()
        self._endings: dict[Job[Any], Callable[[Job[Any]], object]] = {}
        self._journal = journal
        # After an interruption: LOCK is owed, and its job once it is sent.
        self._is_lock_owed = False
        self._owed: Job[Any] | None = None
        self._adapter = ""  # where LOCK may be owed
        self._return = Reconnection()
        self.worker = Worker(self._batches.put, make_lock=None if journal is None else self._make_lock)
        self.worker.closing_limit_s = UNDO_LIMIT_S
        self.connection = Connection()
        self.conversation = ConversationView()
        # Of the port while it was open.
        self.counters, self.noise = Counters(), b""
        self.has_seen_triggered = False
        self.has_left = False  # a set or an act, of a procedure that has not ended
        self._jobs: list[Job[Any]] = []
        # Of the conversation that this command is about; 0 before the module was greeted.
        self.number = 0

    def open(self, port: str, baud_rate: int, background: Background = None) -> None:
        """Open the port. Raises `PortError`, or `NoLink` if it does not open within two seconds."""
        self.worker.start()
        if self._journal is not None:
            # LOCK is owed at this adapter, whatever its name is by then.
            self._adapter = adapter_of(port)
            self._return.request(Target(port, baud_rate, self._adapter))
        self.worker.open(port, baud_rate, background, adapter=self._adapter or port)
        if not self.wait_until(lambda: self.connection.state is PortState.OPEN, OPENING_LIMIT_S):
            late = tr("{port} does not open within {seconds:.0f} s.", port=port, seconds=OPENING_LIMIT_S)
            raise NoLink(join_sentences((late, tr("Plug the adapter in again, or check the address."))))
        self._reopen_if_lost()  # learns whether there are two adapters of its kind

    def submit(self, job: Job[Any], then: Callable[[Job[Any]], object], *, is_urgent: bool = False) -> None:
        """Run a job, and call back when it has ended, behind the listeners."""
        self._endings[job] = then
        self.worker.submit(job, is_urgent=is_urgent)

    def run(self, procedure: Procedure[Result], *, outlives: bool = False) -> Result:
        """Run a procedure, in the conversation in which the module was greeted, and return its result. Raises what the
        procedure raises, and KeyboardInterrupt. `outlives`: it belongs to the port, not to a conversation."""
        job = self.worker.submit(Job(procedure, conversation=None if outlives else self.number))
        self._jobs.append(job)
        while not job.is_done:
            self.wait()
        # What the procedure saw is taken in before its result is used.
        self.drain()
        self.has_left = False
        return job.outcome()

    def wait_until(self, holds: Callable[[], bool], limit_s: float) -> bool:
        """Wait until it holds, at most so long; return whether it does. Raises `PortError`."""
        ends_at = steady_time() + limit_s
        while not holds() and steady_time() < ends_at:
            self.wait()
            if self.connection.trouble is not None:
                raise self.connection.trouble
        return holds()

    def bind(self) -> None:
        # From now on everything runs in the conversation that goes on, and in no other.
        self.drain()
        self.number = self.conversation.number
        _log.debug("bound to conversation %d", self.number)

    def wait(self) -> None:
        """Wait for a batch, at most a tenth of a second. Raises KeyboardInterrupt."""
        check_signals()
        with suppress(queue.Empty):
            self._receive(self._batches.get(timeout=WAIT_S))
        check_signals()

    def drain(self) -> None:
        # Take all batches that are there, without waiting.
        while not self._batches.empty():
            self._receive(self._batches.get())

    def pay_owed_lock(self) -> None:
        """After an activation that was interrupted when its frame had left: wait until a module answers on the same
        adapter, which gets LOCK first, and say what came of it."""
        self.drain()
        if self._is_lock_owed:
            _log.debug("LOCK is owed")
            self._await_lock()

    @property
    def has_activated(self) -> bool:
        """Whether an activation has left; the worker's thread knows it before a batch tells it."""
        return any(job.has_activated for job in self._jobs)

    def lock_what_was_broken_off(self) -> bool:
        """Return after Ctrl-C whether an activation has left. Then it is locked within ten seconds, or until Ctrl-C
        comes again; else none leaves any more."""
        from app.procedures.lock import lock

        def lock_it() -> Procedure["Locked | None"]:
            # In the worker's thread. It overtakes what was decided before, which is not sent after it.
            return (yield from lock(self._journal)) if self.has_activated else None

        if not self._jobs:
            return False
        state.signal = None
        self._owed = self.worker.submit(Job(lock_it(), conversation=None), is_urgent=True)
        with suppress(KeyboardInterrupt):
            self._await_lock()
        return self.has_activated

    def _await_lock(self) -> None:
        ends_at = steady_time() + OWED_LIMIT_S
        locked: Locked | None = None
        try:
            while steady_time() < ends_at and not (self._owed is not None and self._owed.is_done):
                self._reopen_if_lost()
                self.wait()
            if self._owed is not None and self._owed.is_done:
                with suppress(PortError, Interrupted):  # without an open port it was never sent
                    locked = self._owed.outcome()
        finally:
            if locked is not None and locked.is_locked:
                notify(join_sentences((tr("LOCK was sent after the interruption."), locked.sentence)))
            elif self.has_activated:
                notify(tr("ACTIVE, not locked."))

    def _reopen_if_lost(self) -> None:
        # Only the adapter on which LOCK may be owed is opened again.
        now = steady_time()
        self._return.feed(self.connection, now)
        if self.connection.state is not PortState.OPENING and self._return.is_due(now):
            device = self._return.poll(listed_ports(), now)
            if device is not None:
                self.worker.open(device, self.connection.baud_rate, adapter=self._adapter or device)

    def close(self) -> None:
        # Idempotent. Returns in bounded time, even if opening or closing the port hangs.
        self.worker.stop(0.2 if self.connection.state is PortState.OPENING else STOP_LIMIT_S)
        self.drain()

    def _make_lock(self) -> "Job[Locked]":
        # In the worker's thread.
        from app.procedures.lock import OWED, lock

        self._owed = owed = Job(lock(self._journal, pressed_in=OWED), conversation=None)
        return owed

    def _receive(self, batch: Batch) -> None:
        self.connection = batch.connection
        self.conversation = batch.conversation
        if batch.counters is not None:
            self.counters, self.noise = batch.counters, batch.noise
        self._is_lock_owed |= batch.is_lock_owed
        is_reported = batch.conversation.reported[0] is True
        self.has_seen_triggered |= is_reported or any(sample.triggered for sample in batch.samples)
        self.has_left |= any(isinstance(event, Sent) and not event.request.is_repeatable for event in batch.events)
        for on_batch in self.listeners:
            on_batch(batch)
        for job in self._endings.keys() & batch.finished:
            self._endings.pop(job)(job)


@contextmanager
def connected(
    port: str,
    baud_rate: int | None,
    *,
    on_batch: Callable[[Batch], None] | None = None,
    background: Background = None,
    is_greeted: bool = True,
    journal: "Journal | None" = None,
) -> Iterator[OpenPort]:
    """Open `port`, make sure that a module answers on it, and close it afterwards. `baud_rate` None tries all rates.
    `background` makes what runs in each conversation. Without `is_greeted` nobody is waited for. Raises `PortError`,
    `NoLink`, KeyboardInterrupt."""
    opened = OpenPort(on_batch, journal)
    try:
        opened.open(port, baud_rate or USUAL_RATE, background)
        # Else a person would wonder why every command but a question is refused.
        if is_shared(port):
            note(tr(SHARED))
        if is_greeted:
            _greet(opened, port, baud_rate)
        yield opened
        opened.pay_owed_lock()
    except LOST as error:
        _log.debug("%s: %r", port, error)
        if was_heard_active(opened.conversation):
            notify(join_sentences((tr(LAST_HEARD_ACTIVE), keep_away())))
        trouble = opened.connection.trouble
        if trouble is not None and isinstance(error, Interrupted) and error.reason is EndReason.PORT_LOST:
            raise trouble from error  # which names the port
        raise
    except KeyboardInterrupt:
        # Who breaks an activation off wants no module that fires.
        is_locking = journal is not None and opened.lock_what_was_broken_off()
        opened.close()  # which tells the rest of what was sent
        if opened.has_left and not is_locking:
            notify(tr("Interrupted; may have been carried out."))
        raise
    finally:
        opened.close()
        if opened.has_seen_triggered:
            # For the next module that is named at this port: what was said of it before does not hold any more.
            from app.store.acts import note_triggered
            from app.terminal.records import CommandStore

            with CommandStore() as store:
                store.write(lambda facts: note_triggered(facts, port=port, adapter=adapter_of(port)))


def _greet(opened: OpenPort, port: str, baud_rate: int | None) -> None:
    if baud_rate is None:
        if opened.run(find_rate(USUAL_RATE), outlives=True).baud_rate is None:
            raise NoLink(no_module_found(port))
    elif not opened.wait_until(lambda: opened.conversation.is_going, MODULE_LIMIT_S):
        from app.diagnosis.causes import PortEvidence
        from app.diagnosis.silence import what_came

        counters, adapter = opened.counters, adapter_of(port)
        silence = what_came(counters, opened.noise)
        raise no_link(PortEvidence(port, baud_rate, silence=silence, counters=counters, adapter=adapter))
    opened.bind()


def no_link(evidence: "PortEvidence") -> NoLink:
    from app.diagnosis.causes import explain

    why = explain(evidence)
    return NoLink(why.terminal_sentence, what=why.what, hint=why.next_step)


def no_module_found(port: str) -> str:
    what = tr("No module answers on {port} at any baud rate.", port=port)
    return join_sentences((what, tr("Check power, ground and crossed TX and RX.")))


def _trace() -> Callable[[Batch], None]:
    """Prints on standard error what is sent and received, in words; with -vv its bytes, too. Times count from here."""
    from app.captures.explain import event_sentence
    from app.captures.traffic import entries_of

    started_at = steady_time()

    def on_batch(batch: Batch) -> None:
        for event in batch.events:
            shown = "".join(entry.line for entry in entries_of((event,), started_at))
            if state.verbosity < 2 or not shown:
                shown = f"{event.at - started_at:.6f}"
            words = event_sentence(event)
            if words:
                notify(f"{shown}  {words}")

    return on_batch
