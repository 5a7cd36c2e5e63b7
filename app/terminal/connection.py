"""The open port of one command, the conversation on it, and the jobs that run in it.

The worker's thread owns the port; the main thread waits for it, at most a tenth of a second at a time, so that Ctrl-C
is handled. The port is always closed properly.

A job ends with its conversation: `run` raises `Interrupted` then, whose sentence says why.
"""

import queue
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final, TypeVar

from app.engine.conversation import ConversationView, Interrupted
from app.engine.procedure import SHARED, Job, LinkView, Procedure, Report
from app.engine.target import is_network_address, is_shared
from app.engine.transport import PortError
from app.engine.worker import Batch, Connection, OwedLock, PortState, Worker
from app.procedures.find import Silence, await_module, find_rate
from app.safety.last_known import LAST_HEARD_ACTIVE, keep_away, was_heard_active
from app.system.clock import steady_time
from app.terminal.arguments import USUAL_RATE
from app.terminal.console import Refused, clear_progress, note, notify, show_progress, verbosity
from app.terminal.interruption import check_signals, signals_noted
from app.text.i18n import tr
from app.text.sentences import join_sentences
from app.text.user_error import ErrorCode
from protocol.events import EndReason

if TYPE_CHECKING:
    from app.engine.reconnect import Reconnection
    from app.procedures.lock import Locked
    from app.safety.journal import Journal
    from app.terminal.trace import Trace

OPENING_LIMIT_S: Final = 2.0
OWED_LIMIT_S: Final = 10.0
"""How long the command line waits for the module that it owes LOCK."""
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
        self._on_batch = on_batch
        self._journal = journal
        self._trace: Trace | None = None
        if verbosity() > 0:
            from app.terminal import trace

            self._trace = trace.Trace(has_frames=verbosity() > 1)
        self._batches: queue.SimpleQueue[Batch] = queue.SimpleQueue()
        self._wake: Callable[[], None] = lambda: None
        self._worker = Worker(self._hand_over, make_lock=None if journal is None else self._make_lock)
        self._reconnection: Reconnection | None = None  # where LOCK may be owed
        self._report: Report | None = None  # the newest of the procedure that runs; set in the worker's thread
        self._owed: Job[Locked] | None = None
        self.connection = Connection()
        self.conversation = ConversationView()
        self.link: LinkView | None = None
        """Its last state while the port was open."""
        self.owed_lock: OwedLock | None = None
        self.has_seen_triggered = False
        self.number = 0
        """Of the conversation that this command is about; 0 before the module was greeted."""

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
            show_progress(tr("Opening…"))
            self.wait()
            if self.connection.trouble is not None:
                raise self.connection.trouble
            if steady_time() > ends_at:
                late = tr("{port} does not open within {seconds:.0f} s.", port=port, seconds=OPENING_LIMIT_S)
                advice = tr("Unplug the adapter and plug it in again.")
                if is_network_address(port):
                    advice = tr("Check the address and the network.")
                raise NoLink(join_sentences((late, advice)), what=late, hint=advice)
        clear_progress()

    def run(
        self,
        procedure: Procedure[Result],
        *,
        outlives: bool = False,
        limit_s: float | None = None,
    ) -> Result:
        """Run a procedure, in the conversation in which the module was greeted, and return its result. Raises its
        exception, such as `Interrupted`, and `Signalled`.

        `outlives`: it belongs to the port, not to a conversation. `limit_s`: it is cancelled after this time.
        """
        job = Job(procedure, self._note_report, conversation=self.number or None, outlives=outlives)
        self._report = None
        self._worker.submit(job)
        ends_at = None if limit_s is None else steady_time() + limit_s
        try:
            while not job.is_done:
                show_progress(self._doing())
                self.wait()
                if ends_at is not None and steady_time() > ends_at:
                    job.cancel()
        finally:
            clear_progress()
        self.drain()
        is_closed = self.connection.state is PortState.CLOSED and self.connection.trouble is None
        if is_closed and isinstance(job.error, Interrupted):
            raise RuntimeError("the port was closed without a reason") from job.error
        return job.outcome()

    def watch(self, procedure: Procedure[None]) -> Job[None]:
        """Start a procedure in the conversation that goes on; it runs while `wait` is called."""
        return self.submit(Job(procedure, conversation=self.conversation.number))

    def submit(self, job: Job[Result], *, is_urgent: bool = False) -> Job[Result]:
        """As `Worker.submit`."""
        return self._worker.submit(job, is_urgent=is_urgent)

    def listen(self, on_batch: Callable[[Batch], None], wake: Callable[[], None], every_s: float) -> None:
        """From now on `drain` calls `on_batch`, and `wake` is called by the worker's thread when there is a batch, at
        least every `every_s` while anything comes."""
        self._on_batch, self._wake = on_batch, wake
        self._worker.publish_every_s = every_s

    def bind(self) -> None:
        """From now on everything runs in the conversation that goes on, and in no other."""
        self.drain()
        self.number = self.conversation.number

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
        return self.owed_lock is not None or self._owed is not None

    def pay_owed_lock(self) -> "Locked | None":
        """Wait until a module answers on the same adapter, which then gets the LOCK that is owed. None where that has
        not come to an end in time."""
        ends_at = steady_time() + OWED_LIMIT_S
        while steady_time() < ends_at:
            show_progress(tr("Waiting for the module"))
            if self._owed is not None and self._owed.is_done:
                clear_progress()
                return self._owed.outcome()
            self._open_again()
            self.wait()
        clear_progress()
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
        self.owed_lock = batch.owed_lock
        if batch.link is not None:
            self.link = batch.link
        if self._reconnection is not None:
            self._reconnection.feed(batch.connection, batch.at)
        is_reported = batch.conversation.reported[0] is True
        self.has_seen_triggered |= is_reported or any(sample.triggered for sample in batch.samples)
        if self._trace is not None:
            self._trace.on_batch(batch)
        if self._on_batch is not None:
            self._on_batch(batch)

    def _hand_over(self, batch: Batch) -> None:
        """In the worker's thread."""
        self._batches.put(batch)
        self._wake()

    def _note_report(self, report: Report) -> None:
        """In the worker's thread."""
        self._report = report

    def _doing(self) -> str:
        report = self._report
        if report is None:
            return tr("Waiting for the module")
        values = {name: tr(value) if isinstance(value, str) else value for name, value in report.values}
        return f"{tr(report.doing, **values)} ({report.done + 1}/{report.total})"


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
    from app.store.fired import note_unnamed
    from app.terminal.records import adapter_of, opened_store

    with opened_store(_KEEP_LIMIT_S) as (store, _troubles):
        store.write(lambda facts: note_unnamed(facts, port=port, adapter=adapter_of(port)))


def _greet(opened: OpenPort, port: str, baud_rate: int | None) -> None:
    if baud_rate is None:
        search = opened.run(find_rate(USUAL_RATE), outlives=True)
        if search.baud_rate is None:
            raise NoLink(no_module_found(port))
        opened.bind()
        return
    silence = opened.run(await_module(), outlives=True)
    if silence is not None:
        from app.diagnosis.causes import explain
        from app.diagnosis.symptoms import PortEvidence
        from app.terminal.records import adapter_of

        # An address is of no adapter, and listing takes time.
        adapter = "" if "://" in port else adapter_of(port)
        seen = PortEvidence(port, baud_rate, silence=silence, adapter=adapter)
        why = explain(seen if opened.link is None else seen._replace(counters=opened.link.counters))
        raise NoLink(why.terminal_sentence, what=why.what, hint=why.next_step)
    opened.bind()


def loss_sentence(error: Exception) -> str:
    """What to say of one of `LOST`."""
    from app.diagnosis.causes import explain

    return error.sentence if isinstance(error, NoLink) else explain(error).terminal_sentence


def no_module_found(port: str) -> str:
    what = tr("No module answers on {port} at any baud rate.", port=port)
    return join_sentences((what, tr("Check power, ground and crossed TX and RX.")))


def module_is_silent(port: str, conversation: ConversationView) -> str:
    """`conversation`: the last one with it."""
    from app.diagnosis.causes import explain
    from app.diagnosis.symptoms import PortEvidence

    was_active = was_heard_active(conversation)
    why = explain(PortEvidence(port, silence=Silence.NOTHING, was_online=True, was_active=was_active))
    return join_sentences((tr(LAST_HEARD_ACTIVE) if was_active else "", why.terminal_sentence))
