"""The open port of one command, the conversation on it, and the jobs that run in it.

The worker's thread owns the port; the main thread waits for it, at most a tenth of a second at a time, so that Ctrl-C
is handled. The port is always closed properly.

A job ends with its conversation: `run` raises `Interrupted` then, whose sentence says why.
"""

import logging
import queue
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final, TypeVar

from app.engine.conversation import ConversationView, Interrupted
from app.engine.procedure import SHARED, Job, LinkView, Procedure
from app.engine.target import is_network_address, is_shared
from app.engine.transport import PortError
from app.engine.worker import Batch, Connection, PortState, Worker
from app.procedures.find import Silence, await_module, find_rate
from app.safety.last_known import LAST_HEARD_ACTIVE, keep_away, was_heard_active
from app.system.clock import steady_time
from app.terminal.arguments import USUAL_RATE
from app.terminal.console import Refused, note, notify, verbosity
from app.terminal.interruption import check_signals, signals_noted
from app.text.i18n import tr
from app.text.messages import ErrorCode, join_sentences
from protocol.events import EndReason

if TYPE_CHECKING:
    from app.diagnosis.symptoms import PortEvidence
    from app.engine.reconnect import Reconnection
    from app.procedures.lock import Locked
    from app.safety.journal import Journal

_log = logging.getLogger(__name__)
OPENING_LIMIT_S: Final = 2.0
# How long the command line waits for the module that it owes LOCK.
OWED_LIMIT_S: Final = 10.0
STOP_LIMIT_S: Final = 1.0
_WAIT_S: Final = 0.1
_KEEP_LIMIT_S: Final = 2.0

Result = TypeVar("Result")


class NoLink(Refused):
    """No module answers."""

    def __init__(self, sentence: str, *, what: str = "", hint: str = "") -> None:
        super().__init__(sentence, ErrorCode.NO_LINK, what=what, hint=hint)


# What ends a conversation, or keeps it from beginning.
LOST: Final = (PortError, NoLink, Interrupted)


class OpenPort:
    """Made by `connected`, used by one thread. `on_batch` is called in that thread with all batches, in order."""

    def __init__(self, on_batch: Callable[[Batch], None] | None, journal: "Journal | None") -> None:
        """`journal`: of a command that activates, and so may owe LOCK."""
        self._listeners = [] if on_batch is None else [on_batch]
        self._journal = journal
        if verbosity() > 0:
            from app.terminal.trace import Trace

            self._listeners.append(Trace(has_frames=verbosity() > 1).on_batch)
        self._batches: queue.SimpleQueue[Batch] = queue.SimpleQueue()
        self._worker = Worker(self._batches.put, make_lock=None if journal is None else self._make_lock)
        self._reconnection: Reconnection | None = None  # where LOCK may be owed
        self._owed: Job[Locked] | None = None
        self._is_lock_owed = False
        self.connection = Connection()
        self.conversation = ConversationView()
        # Its last state while the port was open.
        self.link: LinkView | None = None
        self.has_seen_triggered = False
        # Of the conversation that this command is about; 0 before the module was greeted.
        self.number = 0

    def open(self, port: str, baud_rate: int) -> None:
        """Raises `PortError`, or `NoLink` if the port does not open within two seconds."""
        self._worker.start()
        adapter = ""
        if self._journal is not None:
            from app.engine.ports import list_ports
            from app.engine.reconnect import Reconnection, address_of

            address = address_of(port, list_ports())
            self._reconnection = Reconnection()
            self._reconnection.request(address)
            adapter = address.identity
        self._worker.open(port, baud_rate, adapter=adapter or port)
        ends_at = steady_time() + OPENING_LIMIT_S
        while self.connection.state is not PortState.OPEN:
            self.wait()
            if self.connection.trouble is not None:
                raise self.connection.trouble
            if steady_time() > ends_at:
                late = tr("{port} does not open within {seconds:.0f} s.", port=port, seconds=OPENING_LIMIT_S)
                advice = tr("Unplug the adapter and plug it in again.")
                if is_network_address(port):
                    advice = tr("Check the address and the network.")
                raise NoLink(join_sentences((late, advice)), what=late, hint=advice)

    def run(self, procedure: Procedure[Result], *, outlives: bool = False) -> Result:
        """Run a procedure, in the conversation in which the module was greeted, and return its result. Raises its
        exception, such as `Interrupted`, and `Signalled`. `outlives`: it belongs to the port, not to a conversation."""
        job = self.submit(Job(procedure, conversation=self.number or None, outlives=outlives))
        while not job.is_done:
            self.wait()
        self.drain()
        return job.outcome()

    def submit(self, job: Job[Result], *, is_urgent: bool = False) -> Job[Result]:
        """As `Worker.submit`; it runs while `wait` is called."""
        return self._worker.submit(job, is_urgent=is_urgent)

    def listen(self, on_batch: Callable[[Batch], None], every_s: float) -> None:
        """From now on `on_batch` is called, too, and there is a batch at least every `every_s` while anything comes."""
        self._listeners.append(on_batch)
        self._worker.publish_every_s = every_s

    def bind(self) -> None:
        """From now on everything runs in the conversation that goes on, and in no other."""
        self.drain()
        self.number = self.conversation.number
        _log.debug("bound to conversation %d", self.number)

    def wait(self) -> None:
        """Wait for a batch, at most a tenth of a second. Raises `Signalled`."""
        check_signals()
        with suppress(queue.Empty):
            self._receive(self._batches.get(timeout=_WAIT_S))
        check_signals()

    def drain(self) -> None:
        """Take all batches that are there, without waiting."""
        with suppress(queue.Empty):
            while True:
                self._receive(self._batches.get_nowait())

    @property
    def owes_lock(self) -> bool:
        """An activation was interrupted after its frame had left."""
        self.drain()
        return self._is_lock_owed or self._owed is not None

    def pay_owed_lock(self) -> "Locked | None":
        """Wait until a module answers on the same adapter, which then gets the LOCK that is owed. None where that has
        not come to an end in time."""
        _log.debug("LOCK is owed")
        ends_at = steady_time() + OWED_LIMIT_S
        while steady_time() < ends_at:
            if self._owed is not None and self._owed.is_done:
                return self._owed.outcome()
            self._open_again()
            self.wait()
        return None

    def close(self) -> None:
        """Idempotent. Returns in bounded time, even if opening or closing the port hangs."""
        limit_s = 0.2 if self.connection.state is PortState.OPENING else STOP_LIMIT_S
        self._worker.stop(limit_s)
        self.drain()

    def _make_lock(self) -> "Job[Locked]":
        """In the worker's thread."""
        from app.procedures.lock import lock

        self._owed = Job(lock(self._journal, is_owed=True), outlives=True)
        return self._owed

    def _open_again(self) -> None:
        """Open a port that was lost, if its adapter is back."""
        from app.engine.ports import list_ports

        now = steady_time()
        if self._reconnection is not None and self._reconnection.is_due(now):
            ports = list_ports() if self._reconnection.needs_ports else ()
            address = self._reconnection.poll(ports, now)
            if address is not None:
                rate = self.connection.baud_rate
                self._worker.open(address.device, rate, adapter=address.identity or address.device)

    def _receive(self, batch: Batch) -> None:
        self.connection = batch.connection
        self.conversation = batch.conversation
        self.link = batch.link or self.link
        self._is_lock_owed = batch.owed_lock is not None
        if self._reconnection is not None:
            self._reconnection.feed(batch.connection, batch.at)
        is_reported = batch.conversation.reported[0] is True
        self.has_seen_triggered |= is_reported or any(sample.triggered for sample in batch.samples)
        for on_batch in self._listeners:
            on_batch(batch)


@contextmanager
def connected(
    port: str,
    baud_rate: int | None,
    *,
    on_batch: Callable[[Batch], None] | None = None,
    is_greeted: bool = True,
    journal: "Journal | None" = None,
) -> Iterator[OpenPort]:
    """Open `port`, make sure that a module answers on it, and close it afterwards. `baud_rate` None tries all rates.
    Without `is_greeted` nobody is waited for. Raises `PortError`, `NoLink`, `Signalled`."""
    with signals_noted():
        opened = OpenPort(on_batch, journal)
        try:
            opened.open(port, baud_rate or USUAL_RATE)
            if is_shared(port):
                note(tr(SHARED))
            if is_greeted:
                _greet(opened, port, baud_rate)
            yield opened
        except LOST as error:
            _log.debug("%s: %r", port, error)
            if was_heard_active(opened.conversation):
                notify(join_sentences((tr(LAST_HEARD_ACTIVE), keep_away())))
            trouble = opened.connection.trouble
            is_port_lost = isinstance(error, Interrupted) and error.reason is EndReason.PORT_LOST
            if is_port_lost and trouble is not None:
                raise trouble from error  # which names the port
            raise
        finally:
            opened.close()
            if opened.has_seen_triggered:
                _keep_triggered(port)


def _keep_triggered(port: str) -> None:
    """For the next module that is named at this port: whatever was said of it before does not hold any more. A store
    that hangs is waited for within a limit, as by LOCK."""
    from app.store.acts import note_unnamed
    from app.terminal.records import adapter_of, opened_store

    with opened_store(_KEEP_LIMIT_S) as (store, _troubles):
        store.write(lambda facts: note_unnamed(facts, port=port, adapter=adapter_of(port)))


def _greet(opened: OpenPort, port: str, baud_rate: int | None) -> None:
    if baud_rate is None:
        if opened.run(find_rate(USUAL_RATE), outlives=True).baud_rate is None:
            raise NoLink(no_module_found(port))
    elif (silence := opened.run(await_module(), outlives=True)) is not None:
        from app.diagnosis.symptoms import PortEvidence
        from app.terminal.records import adapter_of

        # An address is of no adapter, and listing takes time.
        adapter = "" if "://" in port else adapter_of(port)
        seen = PortEvidence(port, baud_rate, silence=silence, adapter=adapter)
        raise _no_link(seen if opened.link is None else seen._replace(counters=opened.link.counters))
    opened.bind()


def _no_link(evidence: "PortEvidence") -> NoLink:
    from app.diagnosis.causes import explain

    why = explain(evidence)
    return NoLink(why.terminal_sentence, what=why.what, hint=why.next_step)


def loss_sentence(error: Exception) -> str:
    """What to say of one of `LOST`."""
    from app.diagnosis.causes import explain

    return error.sentence if isinstance(error, NoLink) else explain(error).terminal_sentence


def no_module_found(port: str) -> str:
    what = tr("No module answers on {port} at any baud rate.", port=port)
    return join_sentences((what, tr("Check power, ground and crossed TX and RX.")))


def module_is_silent(port: str, conversation: ConversationView) -> str:
    """`conversation`: the last one with it."""
    from app.diagnosis.symptoms import PortEvidence

    was_active = was_heard_active(conversation)
    silence = PortEvidence(port, silence=Silence.NOTHING, was_online=True, was_active=was_active)
    return join_sentences((tr(LAST_HEARD_ACTIVE) if was_active else "", _no_link(silence).sentence))
