"""Endless status reports: streamed if the module streams, else polled.

The serial output is left as it was found. Its state cannot be read (E8), so the procedure listens before it switches
the output on; a module that streams already is left streaming.
"""

from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, field

from app.engine.device import DeviceView, How
from app.engine.procedure import Ask, Cancelled, EngineView, Inspect, Pause, Procedure, Slept, TwoModules, is_alive
from app.engine.setting_changes import READABLE_SETTINGS
from app.procedures.read import read_everything
from app.store.stream_memory import StreamMemory
from protocol.catalogue import BY_NAME, SERIAL_OUTPUT, STATUS, Request
from protocol.events import Answered, OutcomeUnknown
from protocol.link_states import Presence
from protocol.messages import Acknowledgement

LISTEN_FIRST_S = 2.2
"""The slowest stream, one report a second, sends two reports within this time."""
BRIEF_LISTEN_S = 0.2
"""For `listens_briefly`: whether it was on before is then derived from its rate."""
BRIEF_UNPOLLED_S = 0.5
"""The status is not polled before, as the stream is about to begin."""
MIN_EXPECTED = 3.0
"""Reports that a stream would have sent while listening; a slower one may have been on unnoticed."""
RESTART_NOTICED_S = 2.0
"""A restart noticed this soon after "on" may have been before it, so the stream may still be ours."""
STREAM_STARTS_S = 1.5
"""Without a report for this long after "on" the module does not stream."""
POLL_EVERY_S = 0.1
UNSEEN_POLL_EVERY_S = 0.5
"""While nothing needs the stream; enough for the state in the top bar."""
SLOW_EVERY_S = 1.0
BOOT_EVERY_S = 10.0
SETTINGS_EVERY_S = 10.0
"""A setting that changed after it was verified is noticed within this time."""
TURN_S = 0.01
REST_S = 0.1
"""The longest pause while no question is due."""
OFF_ATTEMPTS = 3
_BOOT_COUNT = BY_NAME["boot_count"].query()
_SETTINGS = tuple((command.query(), SETTINGS_EVERY_S) for command in READABLE_SETTINGS)
_SLOW = tuple(BY_NAME[name].query() for name in ("cell_voltage", "charging", "light"))


@dataclass(slots=True)
class StreamSwitch:
    """Whether the stream is needed. Set by any thread, read by the procedure."""

    is_wanted: bool = True
    """A visible page shows it."""
    is_recorded: bool = False
    """The session is being recorded."""
    began_at: float | None = None
    """Set by the procedure: when the reports began, streamed or polled."""
    is_unknown_before: bool = False
    """Set by the procedure: the stream is so slow that it may have been on before."""

    @property
    def is_on(self) -> bool:
        return self.is_wanted or self.is_recorded


@dataclass(slots=True)
class _StreamProgress:
    memory: StreamMemory
    listens_briefly: bool = False
    has_come: bool = False
    """A report came unasked."""
    listened_s: float = 0.0
    """The time before it was switched on."""
    hz: float = 0.0
    """Its rate since then."""
    intent: Future[None] | None = None
    """Done when it is stored that the stream was switched on."""
    switched_on_at: float | None = None
    may_be_ours: bool = False
    """It restarted about when the stream was switched on: a stream that appears is ours to switch off."""
    has_given_up: bool = False
    """It was switched on and nothing came: polled until the next restart."""
    device: DeviceView = field(default_factory=DeviceView)
    """At the last turn."""
    has_read: bool = False
    due: dict[Request, float] = field(default_factory=dict)
    """When each question is due next."""
    rests_until: float = 0.0
    """No question is due before."""


def watch(
    switch: StreamSwitch, *, read_all: bool = True, memory: StreamMemory | None = None, listens_briefly: bool = False
) -> Procedure[None]:
    """Keep everything about the module fresh until cancelled. `read_all`: ask for everything first, and again after a
    restart, a lost link or a sleep. The status is polled until it is known whether the stream was on already. `memory`:
    a stream that an earlier session left on is switched off. `listens_briefly`: switch it on as soon as a usual stream
    would have shown."""
    progress = _StreamProgress(memory or StreamMemory(), listens_briefly)
    try:
        while True:
            # On the command line it is in the foreground, and goes on as in the background.
            with suppress(Slept, TwoModules):
                view: EngineView = yield Inspect()
                yield from _turn(progress, switch, view, read_all=read_all)
                yield Pause(min(REST_S, max(TURN_S, progress.rests_until - view.now)))
    except Cancelled:  # not if the port was lost
        yield from _switch_off(progress, switch)
        raise


def _turn(progress: _StreamProgress, switch: StreamSwitch, view: EngineView, *, read_all: bool) -> Procedure[None]:
    if view.device.presence is Presence.OFFLINE:
        progress.has_read = False  # everything is read again once the link's own heartbeats are answered
        return
    before, now = progress.device, view.device
    progress.device = now
    # Where a stream ends that nobody switched off, or has a gap, it may not be the module that sent it.
    has_ended = before.is_streaming and not now.is_streaming
    if has_ended or (now.breaks, now.stream_gaps) != (before.breaks, before.stream_gaps):
        for question, _every_s in (*_SETTINGS, (_BOOT_COUNT, BOOT_EVERY_S)):
            progress.due.pop(question, None)  # another module may answer now, or this one after a restart
    if now.restarts != before.restarts:
        on_at = progress.switched_on_at
        progress.may_be_ours = on_at is not None and view.now - on_at < RESTART_NOTICED_S
        progress.switched_on_at, progress.has_given_up, progress.has_read = None, False, False
        progress.intent = None
    if now.last_sleep != before.last_sleep:
        progress.has_read = False
    if now.is_restart_suspected and not before.is_restart_suspected:
        progress.due.pop(_BOOT_COUNT, None)
    if not progress.has_read:
        progress.has_read = not (read_all and (yield from read_everything()).is_silent)
        # One after the other: while the module streams, its silence shows only in a question.
        progress.due |= {question: view.now + at * SLOW_EVERY_S / len(_SLOW) for at, question in enumerate(_SLOW)}
        if read_all:
            progress.due |= {question: view.now + every_s for question, every_s in _SETTINGS}
            return
    yield from _steer_stream(progress, switch, view)
    polled = [*_polled(switch, view), *_SETTINGS]
    is_beginning = progress.listens_briefly and switch.began_at is None and not progress.has_come
    if is_beginning and view.now - view.opened_at < BRIEF_UNPOLLED_S:
        # A streamed report could be mistaken for its answer.
        polled = [(request, every_s) for request, every_s in polled if request.command is not STATUS]
    due = [(request, every_s) for request, every_s in polled if view.now >= progress.due.get(request, 0.0)]
    if due:
        # The longest overdue in periods of its own: on a slow line the status must not starve the others.
        request, every_s = max(due, key=lambda asked: (view.now - progress.due.get(asked[0], 0.0)) / asked[1])
        progress.due[request] = view.now + every_s
        if request in _SLOW:
            # One after the other: while the module streams, its silence shows only in a question.
            for other in _SLOW:
                if other != request:
                    progress.due[other] = max(progress.due.get(other, 0.0), view.now + SLOW_EVERY_S / len(_SLOW))
        if not isinstance((yield Ask(request, attempts=1)), Answered):  # it is repeated soon anyway
            yield from is_alive()
        yield from _confirm_change(progress, request, view)
    progress.rests_until = 0.0 if is_beginning else min(progress.due.get(request, 0.0) for request, _ in polled)


def _confirm_change(progress: _StreamProgress, request: Request, before: EngineView) -> Procedure[None]:
    """Ask again at once for a setting that changed: it may have been a damaged frame."""
    key, after = request.command.key, (yield Inspect())
    old, new = before.device.values.get(key), after.device.values.get(key)
    if request.command in READABLE_SETTINGS and old is not None and new is not None and old.value != new.value:
        progress.due[request] = 0.0


def _steer_stream(progress: _StreamProgress, switch: StreamSwitch, view: EngineView) -> Procedure[None]:
    memory, listened_s = progress.memory, view.now - view.opened_at
    boots = view.device.fresh(_BOOT_COUNT.command.key, view.now)
    if memory.was_left_on and progress.switched_on_at is None and view.is_settled:
        if memory.boot_count is not None and boots not in (None, memory.boot_count):
            memory.clear()  # another module's, or before a restart: the stream was not switched on here
        elif view.device.is_streaming and memory.boot_count in (None, boots):
            progress.switched_on_at = view.now
            memory.take_over()
        elif not view.device.is_streaming and listened_s >= LISTEN_FIRST_S:
            memory.clear()
    if progress.may_be_ours and progress.switched_on_at is None and view.device.is_streaming:
        progress.switched_on_at, progress.may_be_ours = view.now, False
    if not switch.is_on:
        yield from _switch_off(progress, switch)
        return
    if switch.began_at is None and view.device.is_streaming:
        switch.began_at = view.opened_at
    if progress.switched_on_at is not None:
        waited_s = view.now - progress.switched_on_at
        progress.hz = view.device.stream_hz if view.device.is_streaming else progress.hz
        progress.has_given_up = not view.device.is_streaming and waited_s > STREAM_STARTS_S
        return
    if view.device.is_streaming or progress.has_given_up or not view.is_settled or _is_listening(progress, view):
        return
    if progress.intent is None:
        progress.intent = memory.note_on(None if boots is None else int(boots))
    if not progress.intent.done():
        return
    # Set before the answer, so that an unconfirmed or cancelled "on" is switched off again.
    progress.switched_on_at, progress.listened_s, progress.hz = view.now, listened_s, 0.0
    if switch.began_at is None:
        switch.began_at = view.now
    outcome = yield Ask(SERIAL_OUTPUT.set(True))
    refused = isinstance(outcome, Answered) and not _is_accepted(outcome)
    if refused or not isinstance(outcome, Answered | OutcomeUnknown):
        progress.switched_on_at, progress.intent = None, None
        progress.has_given_up = True
        memory.clear()


def _is_listening(progress: _StreamProgress, view: EngineView) -> bool:
    """Whether it is still unknown if a stream was on already."""
    progress.has_come |= any(known.how is How.STREAMED for known in view.device.values.values())
    limit_s = BRIEF_LISTEN_S if progress.listens_briefly and not progress.has_come else LISTEN_FIRST_S
    return view.now - view.opened_at < min(limit_s, LISTEN_FIRST_S)


def _is_accepted(outcome: Answered) -> bool:
    return any(isinstance(message, Acknowledgement) and message.is_accepted for message in outcome.messages)


def _polled(switch: StreamSwitch, view: EngineView) -> Iterator[tuple[Request, float]]:
    """Questions with their period in seconds; the status only if it is not streamed."""
    if not view.device.is_streaming:
        yield STATUS.query(), POLL_EVERY_S if switch.is_on else UNSEEN_POLL_EVERY_S
    for request in _SLOW:
        yield request, SLOW_EVERY_S
    yield _BOOT_COUNT, BOOT_EVERY_S


def _switch_off(progress: _StreamProgress, switch: StreamSwitch) -> Procedure[None]:
    """Switch the stream off if this procedure switched it on. Repeated if unanswered, as "off" twice is harmless."""
    if progress.switched_on_at is None:
        return
    switch.is_unknown_before = 0 < progress.hz * progress.listened_s < MIN_EXPECTED and progress.listens_briefly
    for _ in range(OFF_ATTEMPTS):
        outcome = yield Ask(SERIAL_OUTPUT.set(False), (0.12,))
        if isinstance(outcome, Answered) and _is_accepted(outcome):
            progress.memory.clear()
            break
    progress.switched_on_at, progress.intent = None, None
