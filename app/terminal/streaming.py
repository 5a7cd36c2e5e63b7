"""Watches the status of the modules on one port for a command, through the ends of conversations.

In the first conversation the module is made to stream, and its serial output is switched off again at the end. After a
break another module may answer: from then on the status is only polled.
"""

import logging
import math
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from app.engine.conversation import Interrupted, reason_message
from app.engine.procedure import Job
from app.engine.target import is_simulated
from app.engine.worker import Batch
from app.procedures.stream import LISTEN_S, StreamSwitch, watch
from app.store.acts import StreamMemory
from app.system.clock import steady_time
from app.terminal.connection import LOST, OpenPort, connected, loss_sentence, module_is_silent
from app.terminal.console import note, notify
from app.terminal.interruption import Signalled, TimedOut
from app.terminal.records import adapter_of, opened_store
from app.text.i18n import tr
from app.text.messages import join_sentences
from protocol.events import Ended, EndReason, Received
from protocol.messages import Status
from protocol.translatable import marked

_log = logging.getLogger(__name__)
LEFT_ON: Final = marked("Serial output was left on; it is switched off when not needed.")
SILENT_FOR_S: Final = 5.0  # nobody answers for so long: it ends
WITHOUT_STATUS_S: Final = 5.0  # with a time limit: additional time to wait for the first status
CANCEL_LIMIT_S: Final = 1.5  # how long switching the stream off may take at the end


class Watching:
    """All that comes from a port, or for `seconds` from the first status."""

    def __init__(self, port: str, baud_rate: int | None, seconds: float | None, *, reads_all: bool = False) -> None:
        self._port = port
        self._baud_rate = baud_rate
        self._seconds = math.inf if seconds is None else seconds
        self._reads_all = reads_all
        self._batches: deque[Batch] = deque()
        self._job: Job[None] | None = None
        self._number = 0  # of the conversation that is watched
        self.first_at: float | None = None
        self.is_over = False
        # Why the link was lost, after a status had come.
        self.trouble: str | None = None

    def __iter__(self) -> Iterator[Batch]:
        """Yield batches in order, with the reports of the wanted time only, and say why conversations ended. Raises
        `Signalled`, `TimedOut`, and what keeps a conversation from beginning, if no status had come."""
        try:
            with (
                _stream_memory(self._port) as memory,
                connected(self._port, self._baud_rate, on_batch=self._batches.append) as opened,
            ):
                try:
                    yield from self._wait(opened, memory)
                finally:
                    if self._job is not None:  # it undoes what it changed
                        self._job.cancel()
                        self._job.wait(CANCEL_LIMIT_S)
                    opened.drain()
        except (Signalled, TimedOut, *LOST) as error:
            if self.first_at is None:
                raise
            if isinstance(error, TimedOut):
                self.trouble = error.sentence
            elif not isinstance(error, Signalled):
                self.trouble = loss_sentence(error)
        yield from self._take()  # what came while the stream was switched off

    def _wait(self, opened: OpenPort, memory: StreamMemory) -> Iterator[Batch]:
        gives_up_at = steady_time() + self._seconds + WITHOUT_STATUS_S
        while not self.is_over and steady_time() < gives_up_at:
            yield from self._take()
            opened.wait()
            if opened.connection.trouble is not None:
                raise opened.connection.trouble
            self._go_on(opened, memory)
            ended = opened.conversation.ended
            if ended is not None and steady_time() - ended.at > SILENT_FOR_S:
                self.trouble = module_is_silent(self._port, opened.conversation)
                return

    def _take(self) -> Iterator[Batch]:
        while self._batches:
            batch = self._batches.popleft()
            if batch.samples and self.first_at is None:
                self.first_at = batch.samples[0].at
            ends_at = math.inf if self.first_at is None else self.first_at + self._seconds
            if batch.samples and batch.samples[-1].at > ends_at:
                self.is_over = True
            yield batch._replace(
                samples=tuple(sample for sample in batch.samples if sample.at <= ends_at),
                events=tuple(event for event in batch.events if not _is_report(event) or event.at <= ends_at),
            )
            for event in batch.events:
                # An end of the port is said otherwise.
                if isinstance(event, Ended) and event.reason not in (EndReason.CLOSED, EndReason.PORT_LOST):
                    why = reason_message(event.reason, event.contradiction).translated()
                    notify(join_sentences((why, tr("Another module may answer from now on."))))

    def _go_on(self, opened: OpenPort, memory: StreamMemory) -> None:
        """Watch the conversation that goes on. Raises what the job ended with, but for the end of its conversation."""
        if self._job is not None and self._job.is_done:
            job, self._job = self._job, None
            if not isinstance(job.error, Interrupted):
                job.outcome()
        conversation = opened.conversation
        if not conversation.is_going or conversation.number == self._number:
            return
        # A module that answers after a break is not made to stream, but a stream of this program is switched off.
        listen_s = LISTEN_S if self._number == 0 else math.inf
        self._number = conversation.number
        _log.debug("watching conversation %d", self._number)
        watched = watch(StreamSwitch(), read_all=self._reads_all, memory=memory, listen_s=listen_s)
        self._job = opened.submit(Job(watched, conversation=self._number))


def _is_report(event: object) -> bool:
    return isinstance(event, Received) and isinstance(event.message, Status)


@contextmanager
def _stream_memory(port: str) -> Iterator[StreamMemory]:
    """Remembers that the serial output is switched on; not for simulated modules."""
    if is_simulated(port):
        yield StreamMemory()
        return
    with opened_store() as (store, _troubles):
        memory = StreamMemory(store, adapter_of(port) or port)
        try:
            yield memory
        finally:
            if memory.is_taken_over:
                note(tr(LEFT_ON))
