"""Watches the status of the modules on one port for a command, through the ends of conversations.

In the first conversation the module is made to stream, and its serial output is switched off again at the end. After a
break another module may answer: from then on the status is only polled.
"""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

from app.engine.conversation import Interrupted, reason_message
from app.engine.procedure import Job
from app.engine.target import is_simulated
from app.engine.worker import Batch
from app.procedures.stream import LISTEN_S, StreamSwitch, watch
from app.store.stream_memory import StreamMemory
from app.system.clock import steady_time
from app.terminal.command_journal import adapter_of, opened_store
from app.terminal.connection import LOST, OpenPort, connected, loss_sentence, module_is_silent
from app.terminal.console import note
from app.terminal.interruption import Signalled
from app.text.i18n import tr
from app.text.sentences import join_sentences
from protocol.events import Ended, EndReason
from protocol.translatable import marked

LEFT_ON: Final = marked("Serial output was left on; it is switched off when not needed.")
SILENT_FOR_S: Final = 5.0
"""Nobody answers for so long: it ends."""
WITHOUT_STATUS_S: Final = 5.0
"""With a time limit: additional time to wait for the first status."""
_SAID_OTHERWISE: Final = (EndReason.CLOSED, EndReason.PORT_LOST)
CANCEL_LIMIT_S: Final = 1.5
"""How long switching the stream off may take at the end."""


class StreamSpan:
    """The requested part: all, or `seconds` from the first status."""

    def __init__(self, seconds: float | None) -> None:
        self.seconds = seconds
        self.first_at: float | None = None
        self.is_over = False
        self.was_interrupted = False
        """A signal ended it after the first status."""

    @property
    def has_begun(self) -> bool:
        """Whether a status came."""
        return self.first_at is not None

    def holds(self, at: float) -> bool:
        """Whether a status at this time belongs to it. Call it in order of time."""
        if self.first_at is None:
            self.first_at = at
        if self.seconds is not None and at - self.first_at > self.seconds:
            self.is_over = True
        return not self.is_over


def stream(
    port: str,
    baud_rate: int | None,
    span: StreamSpan,
    *,
    on_batch: Callable[[Batch], None],
    on_turn: Callable[[OpenPort], None],
    reads_all: bool = False,
) -> str | None:
    """Stream until the span or the user ends it; a sentence if the link was lost. `on_turn` is called at least ten
    times a second. Raises `Signalled`, and what keeps a conversation from beginning, if no status had come."""
    try:
        with _stream_memory(port) as memory, connected(port, baud_rate, on_batch=on_batch) as opened:
            watching = _Watching(opened, memory, reads_all=reads_all)
            try:
                return _wait(opened, watching, port, span, on_turn)
            finally:
                watching.stop()
    except Signalled:
        if not span.has_begun:
            raise
        span.was_interrupted = True
        return None
    except LOST as error:
        if not span.has_begun:
            raise
        return loss_sentence(error)


def marks_in(batch: Batch) -> list[str]:
    """What is to be said between two conversations. Not at once: nobody may read, and `on_batch` is also called while
    the port is closed, when no alarm ends a line that is stuck."""
    return [
        join_sentences(
            (
                reason_message(event.reason, event.contradiction).translated(),
                tr("Another module may answer from now on."),
            )
        )
        for event in batch.events
        if isinstance(event, Ended) and event.reason not in _SAID_OTHERWISE
    ]


class _Watching:
    """The job that watches: another one in each conversation."""

    def __init__(self, opened: OpenPort, memory: StreamMemory, *, reads_all: bool) -> None:
        self._opened = opened
        self._memory = memory
        self._reads_all = reads_all
        self._job: Job[None] | None = None
        self._number = 0

    def go_on(self) -> None:
        """Watch the conversation that goes on. Raises what the job ended with, but for the end of its conversation."""
        if self._job is not None and self._job.is_done:
            job, self._job = self._job, None
            if not isinstance(job.error, Interrupted):
                job.outcome()
        conversation = self._opened.conversation
        if not conversation.is_going or conversation.number == self._number:
            return
        # A module that answers after a break is not made to stream, but a stream of this program is switched off.
        listen_s = LISTEN_S if self._number == 0 else math.inf
        self._number = conversation.number
        procedure = watch(StreamSwitch(), read_all=self._reads_all, memory=self._memory, listen_s=listen_s)
        self._job = self._opened.watch(procedure)

    def stop(self) -> None:
        """After it undid what it changed. Never raises."""
        if self._job is not None:
            self._job.cancel()
            self._job.wait(CANCEL_LIMIT_S)
        self._opened.drain()


def _wait(
    opened: OpenPort, watching: _Watching, port: str, span: StreamSpan, on_turn: Callable[[OpenPort], None]
) -> str | None:
    gives_up_at = math.inf if span.seconds is None else steady_time() + span.seconds + WITHOUT_STATUS_S
    while not span.is_over and steady_time() < gives_up_at:
        on_turn(opened)
        opened.wait()
        if opened.connection.trouble is not None:
            raise opened.connection.trouble
        watching.go_on()
        ended = opened.conversation.ended
        if ended is not None and steady_time() - ended.at > SILENT_FOR_S:
            span.is_over = True
            return module_is_silent(port, opened.conversation)
    return None


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
