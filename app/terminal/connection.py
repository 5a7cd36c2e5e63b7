"""Connection of one sub-command, from opening the port to closing it.

The worker's thread owns the port; the main thread waits for it, at most a tenth of a second at a time, so that Ctrl-C
is handled. The port is always closed properly.
"""

import queue
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from app.engine.address_lock import is_network_address
from app.engine.device import DeviceView
from app.engine.procedure import LinkView, PortLost, Procedure, Report, Slept, TwoModules
from app.engine.transport import PortError
from app.engine.worker import Batch, Connection, Job, PortState, Worker
from app.procedures.find import find_rate
from app.procedures.handshake import Silence, handshake
from app.safety.last_known import LAST_HEARD_ACTIVE, keep_away, was_heard_active
from app.terminal.arguments import USUAL_RATE
from app.terminal.console import Refused, clear_progress, notify, show_progress, verbosity
from app.terminal.interruption import Interruption
from app.text.i18n import tr
from app.text.sentences import join_sentences
from app.text.user_error import ErrorCode
from protocol.link_states import Presence

if TYPE_CHECKING:
    from app.diagnosis.causes import Diagnosis
    from app.terminal.trace import Trace

OPENING_LIMIT_S = 2.0
CANCEL_LIMIT_S = 1.5
"""How long a cancelled procedure may take to undo what it changed."""
CANCEL_OFFLINE_LIMIT_S = 0.3
"""The same if the module does not answer: one attempt."""
STOP_LIMIT_S = 1.0
_WAIT_S = 0.1
_KEEP_LIMIT_S = 2.0

Result = TypeVar("Result")


class NoLink(Refused):
    """There is no link, for a reason that is no `PortError`. `what` and `hint`: the two parts of the sentence, where
    it has two."""

    def __init__(self, sentence: str, *, what: str = "", hint: str = "") -> None:
        super().__init__(sentence, ErrorCode.NO_LINK)
        self.what = what
        self.hint = hint


class Conversation:
    """An open port. Made by `connected`, used by one thread. `on_batch` is called in that thread with all batches, in
    order."""

    def __init__(self, interruption: Interruption, on_batch: Callable[[Batch], None] | None = None) -> None:
        self._interruption = interruption
        self._on_batch = on_batch
        self._trace: Trace | None = None
        if verbosity() > 0:
            from app.terminal import trace

            self._trace = trace.Trace(has_frames=verbosity() > 1)
        self._batches: queue.SimpleQueue[Batch] = queue.SimpleQueue()
        self._worker = Worker(self._batches.put)
        self._report: Report | None = None
        """The newest of the procedure that runs; set in the worker's thread."""
        self._running: Job[None] | None = None
        self.connection = Connection()
        self.device = DeviceView()
        self.link: LinkView | None = None
        """Its last state while the port was open."""
        self.has_seen_triggered = False

    def open(self, port: str, baud_rate: int) -> None:
        """Raises `PortError`, or `NoLink` if the port does not open within two seconds."""
        self._worker.start()
        self._worker.open(port, baud_rate)
        deadline = time.monotonic() + OPENING_LIMIT_S
        while not self._is_open():
            show_progress(tr("Opening…"))
            self.wait()
            self._raise_trouble()
            if time.monotonic() > deadline and not self._is_open():
                late = tr("{port} does not open within {seconds:.0f} s.", port=port, seconds=OPENING_LIMIT_S)
                advice = tr("Unplug the adapter and plug it in again.")
                if is_network_address(port):
                    advice = tr("Check the address and the network.")
                raise NoLink(join_sentences((late, advice)))
        clear_progress()
        opened_at = time.monotonic()
        while time.monotonic() <= opened_at:  # Windows' clock has a resolution of 16 ms
            self.wait()

    def run(self, procedure: Procedure[Result]) -> Result:
        """Run a procedure and return its result. Raises its exception, or `Interrupted`."""
        self._report = None
        job = self._worker.submit(Job(procedure, partial(setattr, self, "_report")))
        try:
            while not job.is_done:
                show_progress(self._doing())
                self.wait()
        finally:
            clear_progress()
        self.drain()
        return self._outcome(job)

    def start_background(self, procedure: Procedure[None]) -> None:
        """Start a procedure that runs until `stop_background` or the end of the conversation."""
        self._running = self._worker.submit(Job(procedure))

    def check_running(self) -> None:
        """Raises the exception of the procedure that keeps running, if it ended with one."""
        if self._running is not None and self._running.is_done:
            self._outcome(self._running)

    def stop_background(self) -> None:
        """Cancel the procedure that keeps running, after it undid what it changed. Never raises; 1.5 s at most."""
        job, self._running = self._running, None
        if job is not None:
            job.cancel()
            is_offline = self.device.presence is Presence.OFFLINE
            job.wait(CANCEL_OFFLINE_LIMIT_S if is_offline else CANCEL_LIMIT_S)
        self.drain()

    def wait(self) -> None:
        """Wait for a batch, at most a tenth of a second. Raises `Interrupted`."""
        self._interruption.check()
        with suppress(queue.Empty):
            self._receive(self._batches.get(timeout=_WAIT_S))
        self._interruption.check()

    def drain(self) -> None:
        """Take all batches that are there, without waiting."""
        while True:
            try:
                self._receive(self._batches.get_nowait())
            except queue.Empty:
                return

    def close(self) -> None:
        """Idempotent. Returns in bounded time, even if opening or closing the port hangs."""
        self.stop_background()
        limit_s = 0.2 if self.connection.state is PortState.OPENING else STOP_LIMIT_S
        self._worker.stop(limit_s)
        self.drain()

    def _receive(self, batch: Batch) -> None:
        self.connection = batch.connection
        if batch.link is not None:
            self.link = batch.link
        self.device = batch.device
        triggered = batch.device.values.get("triggered")
        is_reported = triggered is not None and triggered.value is True
        self.has_seen_triggered |= is_reported or any(sample.triggered for sample in batch.samples)
        if self._trace is not None:
            self._trace.on_batch(batch)
        if self._on_batch is not None:
            self._on_batch(batch)

    def _is_open(self) -> bool:
        return self.connection.state is PortState.OPEN

    def _raise_trouble(self) -> None:
        if self.connection.state is PortState.CLOSED and self.connection.trouble is not None:
            raise self.connection.trouble

    def _outcome(self, job: Job[Result]) -> Result:
        try:
            return job.outcome()
        except PortLost as error:  # a lost port raises its own error
            raise RuntimeError("the connection ended without a reason") from error

    def _doing(self) -> str:
        report = self._report
        if report is None:
            return tr("Waiting for the module")
        text = report.doing
        values = {name: tr(value) if isinstance(value, str) else value for name, value in report.values}
        return f"{tr(text, **values)} ({report.done + 1}/{report.total})"


@contextmanager
def connected(
    port: str,
    baud_rate: int | None,
    *,
    on_batch: Callable[[Batch], None] | None = None,
    is_greeted: bool = True,
    interruption: Interruption | None = None,
) -> Iterator[Conversation]:
    """Open `port`, make sure that a module answers on it, and close it afterwards. `baud_rate` None tries all rates.
    Without `is_greeted` nothing is sent. `interruption`: that of the main thread, if this is another one. Raises
    `PortError`, `NoLink`."""
    with Interruption() if interruption is None else nullcontext(interruption) as watched:
        conversation = Conversation(watched, on_batch)
        try:
            try:
                conversation.open(port, baud_rate or USUAL_RATE)
                if is_greeted:
                    _handshake(conversation, port, baud_rate)
                yield conversation
            except (PortError, NoLink):
                if was_heard_active(conversation.device):
                    notify(join_sentences((tr(LAST_HEARD_ACTIVE), keep_away())))
                raise
            finally:
                if interruption is None:
                    watched.ignore_from_now()
        finally:
            # No signal raises here any more.
            conversation.close()
            if conversation.has_seen_triggered:
                _keep_triggered(port)


def _keep_triggered(port: str) -> None:
    """For the next module that is named at this port: whatever was said of it before does not hold any more. A store
    that hangs is waited for within a limit, as by LOCK."""
    from app.store.fired import note_unnamed
    from app.terminal.command_journal import adapter_of, opened_store

    with opened_store(_KEEP_LIMIT_S) as (store, _troubles):
        store.write(lambda facts: note_unnamed(facts, port=port, adapter=adapter_of(port)))


def _handshake(conversation: Conversation, port: str, baud_rate: int | None) -> None:
    if baud_rate is None:
        search = conversation.run(find_rate(USUAL_RATE))
        if search.baud_rate is None:
            raise NoLink(no_module_found(port))
        return
    silence = conversation.run(handshake())
    if silence is not None:
        why = _why_silent(port, baud_rate=baud_rate, silence=silence)
        raise NoLink(why.terminal_sentence, what=why.what, hint=why.next_step)


def no_module_found(port: str) -> str:
    what = tr("No module answers on {port} at any baud rate.", port=port)
    return join_sentences((what, tr("Check power, ground and crossed TX and RX.")))


def module_is_silent(port: str, device: DeviceView) -> str:
    """`device`: what was last heard of it."""
    was_active = was_heard_active(device)
    why = _why_silent(port, silence=Silence.NOTHING, was_online=True, was_active=was_active).terminal_sentence
    return join_sentences((tr(LAST_HEARD_ACTIVE) if was_active else "", why))


def _why_silent(port: str, **seen: Any) -> "Diagnosis":
    from app.diagnosis.causes import explain
    from app.diagnosis.symptoms import PortEvidence

    return explain(PortEvidence(port, **seen))


class LinkTrouble(AbstractContextManager["LinkTrouble"]):
    """Suppresses errors that mean "link lost", and keeps their sentence; other errors are raised."""

    sentence: str | None = None
    error: BaseException | None = None

    def __exit__(self, _kind: object, error: BaseException | None, _trace: object) -> bool:
        self.sentence = link_trouble(error)
        self.error = error
        return self.sentence is not None


def link_trouble(error: BaseException | None) -> str | None:
    """The sentence for an error that means "no link"; None for others."""
    if isinstance(error, NoLink | TwoModules):
        return error.sentence
    if isinstance(error, PortError | Slept):
        from app.diagnosis.causes import explain

        return explain(error).terminal_sentence
    return None
