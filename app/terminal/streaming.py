"""Keeps a module streaming for a command, and restores its serial output afterwards."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from app.engine.device import DeviceView
from app.engine.identity import UNKNOWN, Identity, IdentityEvidence, Trust, evidence_of, is_exchanged, same_module
from app.engine.target import is_simulated
from app.engine.worker import Batch
from app.procedures.stream import StreamSwitch, watch
from app.settings.identity_words import identity_question
from app.store.stream_memory import StreamMemory
from app.terminal.command_journal import adapter_of, opened_store
from app.terminal.connection import Conversation, LinkTrouble, connected, module_is_silent
from app.terminal.console import note, notify
from app.terminal.interruption import Interrupted
from app.text.i18n import tr
from protocol.link_states import Presence
from protocol.translatable import marked

LEFT_ON = marked("Serial output was left on; it is switched off when not needed.")
UNKNOWN_BEFORE = marked("The serial output is off now; it may have been on before.")
WITHOUT_STATUS_S = 5.0
"""With a time limit: additional time to wait for the first status."""
AFTER_SLEEP_S = 3.0
"""How long the module may take to answer after the computer slept."""


class StreamSpan:
    """The requested part of a stream: all, or `seconds` from its first status."""

    def __init__(self, seconds: float | None) -> None:
        self.seconds = seconds
        self.switch = StreamSwitch(is_recorded=True)
        self._earliest_at: float | None = None
        self.is_over = False
        self.was_interrupted = False
        """A signal ended it after the first status."""
        self._first_at: float | None = None

    @property
    def has_begun(self) -> bool:
        """Whether a status came."""
        return self._earliest_at is not None

    def holds(self, at: float) -> bool:
        """Whether a status at this time belongs to it. Call it in order of time."""
        if self._earliest_at is None:
            self._earliest_at = at
        began_at = self.switch.began_at
        if self._first_at is None and began_at is not None and at > began_at:
            # A stream that was on before is only detected after its first reports.
            self._first_at = self._earliest_at if self._earliest_at > began_at else at
        if self.seconds is not None and self._first_at is not None:
            self.is_over |= at - self._first_at > self.seconds
        return not self.is_over


class SameModule:
    """Whether it is the module of before."""

    def __init__(self) -> None:
        self._evidence, self._breaks = UNKNOWN, 0
        """What was read, and how often the conversation had broken then."""
        self.is_in_doubt = False
        """Not everything that may refute it was read since then."""

    def contradiction(self, device: DeviceView) -> str | None:
        """A sentence, translated, where what was read since a restart or a silence refutes it."""
        before, now = self._evidence, evidence_of(device.values, is_fresh=True)
        is_refuted = same_module(before, now) is Trust.REFUTED or (now.is_complete and is_exchanged(before, now))
        is_other = device.breaks != self._breaks and is_refuted
        if is_other or now.is_complete:
            self._evidence, self._breaks = now, device.breaks
        elif device.breaks == self._breaks:  # a heartbeat that may be a restart's puts the boot count in doubt
            boots = before.boot_count if now.boot_count is None else now.boot_count
            self._evidence = IdentityEvidence(boots, {**before.settings, **now.settings})
        self.is_in_doubt = device.breaks != self._breaks
        return identity_question(Identity(Trust.REFUTED, before, now), "") if is_other else None


def stream(
    port: str,
    baud_rate: int | None,
    span: StreamSpan,
    *,
    on_begin: Callable[[Conversation], None],
    on_batch: Callable[[Batch], None],
    on_turn: Callable[[Conversation], None],
    reads_all: bool = False,
) -> str | None:
    """Stream until the span or the user ends it; a sentence if the link was lost. `on_begin` is called when a module
    has answered, `on_turn` at least ten times a second. A stream that this switched on is switched off at the end.
    Raises `Interrupted` and what means "no link" if no status had come."""
    silence: str | None = None
    try:
        with (
            LinkTrouble() as link,
            _stream_memory(port) as memory,
            connected(port, baud_rate, on_batch=on_batch) as conversation,
        ):
            on_begin(conversation)
            procedure = watch(span.switch, read_all=reads_all, memory=memory, listens_briefly=True)
            conversation.start_background(procedure)
            silence = _wait(conversation, port, span, on_turn)
    except Interrupted:
        if not span.has_begun:
            raise
        span.was_interrupted = True
    if link.error is not None and not span.has_begun:
        raise link.error
    if span.switch.is_unknown_before:
        notify(tr(UNKNOWN_BEFORE))
    return link.sentence or silence


def _wait(
    conversation: Conversation, port: str, span: StreamSpan, on_turn: Callable[[Conversation], None]
) -> str | None:
    gives_up_at = None if span.seconds is None else time.monotonic() + span.seconds + WITHOUT_STATUS_S
    while not span.is_over:
        on_turn(conversation)
        conversation.wait()
        conversation.check_running()
        if conversation.device.presence is Presence.OFFLINE and not _has_just_slept(conversation):
            span.is_over = True  # what answers from now on may be another one
            return module_is_silent(port, conversation.device)
        if gives_up_at is not None and time.monotonic() > gives_up_at:
            break
    return None


def _has_just_slept(conversation: Conversation) -> bool:
    """The computer slept, and the module's answer is still to come."""
    sleep = conversation.device.last_sleep
    return sleep is not None and time.monotonic() - sleep.ended_at < AFTER_SLEEP_S


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
