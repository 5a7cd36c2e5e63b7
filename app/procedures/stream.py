"""Keeps everything about the module fresh: status reports, streamed if the module streams, else polled, and the rest.

Made again in each conversation, and ends with it. The link itself notices a silence or a restart, and asks the boot
count every second.

The serial output is left as it was found. Its state cannot be read (E8), so the procedure listens before it switches
the output on; a module that streams already is left streaming. A stream that was left on, because the conversation or
the program ended, is switched off in the next conversation with the module on the same start.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass

from app.engine.procedure import Ask, Cancelled, EngineView, Inspect, Pause, Procedure, is_accepted
from app.procedures.read import read_everything
from app.store.acts import StreamMemory
from protocol.catalogue import BY_NAME, READABLE_SETTINGS, SERIAL_OUTPUT, STATUS, Request
from protocol.events import Unanswered

_log = logging.getLogger(__name__)

# The slowest stream, one report a second, sends two reports within this time.
LISTEN_S = 2.2
# Without a report for this long after "on" the module does not stream.
STREAM_STARTS_S = 1.5
POLL_EVERY_S = 0.1
# While nothing needs the stream; enough for the state in the top bar.
UNSEEN_POLL_EVERY_S = 0.5
SLOW_EVERY_S = 1.0
# A setting that changed after it was verified is noticed within this time.
SETTINGS_EVERY_S = 10.0
APART_S = 0.1
# The shortest and the longest pause between two turns.
TURN_S, REST_S = 0.01, 0.1
OFF_ATTEMPTS = 3
_STATUS = STATUS.query()
_EVERY_S: Mapping[Request, float] = {
    _STATUS: POLL_EVERY_S,
    **{BY_NAME[name].query(): SLOW_EVERY_S for name in ("cell_voltage", "charging", "light")},
    **{command.query(): SETTINGS_EVERY_S for command in READABLE_SETTINGS},
}


@dataclass(slots=True)
class StreamSwitch:
    """Whether the stream is needed. Set by any thread, read by the procedure."""

    is_wanted: bool = True  # a visible page shows it
    is_recorded: bool = False  # the session is being recorded

    @property
    def is_on(self) -> bool:
        return self.is_wanted or self.is_recorded


def watch(switch: StreamSwitch, *, memory: StreamMemory | None = None, listen_s: float = LISTEN_S) -> Procedure[None]:
    """Ask for everything, and go on until it is cancelled or interrupted. `memory`: of streams that were left on.
    `listen_s`: how long to listen before the stream is switched on; a slower one that was on is then switched off at
    the end, too."""
    stream = _Stream(switch, memory or StreamMemory(), listen_s)
    try:
        yield from read_everything()
        view: EngineView = yield Inspect()
        # One after the other, so that together they never hold up a report for long.
        due = {request: view.now + number * APART_S for number, request in enumerate(_EVERY_S)}
        while True:
            view = yield Inspect()
            yield from stream.steer(view)
            # Each in its turn: on a slow line none keeps the others from being asked.
            for request, every_s in _EVERY_S.items():
                if view.now < due[request]:
                    continue
                is_unseen = request == _STATUS and not switch.is_on
                due[request] = view.now + (UNSEEN_POLL_EVERY_S if is_unseen else every_s)
                if request != _STATUS or not view.conversation.is_streaming:
                    yield Ask(request)
            yield Pause(min(REST_S, max(TURN_S, min(due.values()) - view.now)))
    except Cancelled:
        yield from stream.switch_off()
        raise


class _Stream:
    def __init__(self, switch: StreamSwitch, memory: StreamMemory, listen_s: float) -> None:
        self.switch, self.memory, self.listen_s = switch, memory, listen_s
        # When this program switched it on; None if it did not.
        self.on_at: float | None = None
        # It was switched on and nothing came, or the module refused.
        self.has_given_up = False

    def steer(self, view: EngineView) -> Procedure[None]:
        memory, conversation = self.memory, view.conversation
        left_on = memory.left_on
        if self.on_at is None and left_on is not None:
            # By its boot count it is the module of which the stream was left on, or else it was not switched on here.
            if left_on["boot_count"] not in (None, conversation.boot_count):
                memory.clear()
            elif conversation.is_streaming:
                _log.debug("the stream was left on")
                self.on_at = view.now
            elif view.now - conversation.began_at >= LISTEN_S:
                memory.clear()
        if not self.switch.is_on:
            yield from self.switch_off()
            return
        if self.on_at is not None and not conversation.is_streaming and view.now - self.on_at > STREAM_STARTS_S:
            self.has_given_up = True  # it stays polled
        is_busy = conversation.is_streaming or self.on_at is not None or self.has_given_up or conversation.is_shared
        if is_busy or view.now - conversation.began_at < self.listen_s:
            return
        _log.debug("switching the stream on")
        memory.note_on(conversation.boot_count)
        # Set before the answer, so that an unconfirmed or cancelled "on" is switched off again.
        self.on_at = view.now
        outcome = yield Ask(SERIAL_OUTPUT.set(True))
        may_be_on = outcome.may_be_done if isinstance(outcome, Unanswered) else is_accepted(outcome)
        if not may_be_on:
            self.on_at, self.has_given_up = None, True
            memory.clear()

    def switch_off(self) -> Procedure[None]:
        """Switch the stream off if it is this program's. Repeated if unanswered, as "off" twice is harmless."""
        if self.on_at is None:
            return
        for _ in range(OFF_ATTEMPTS):
            outcome = yield Ask(SERIAL_OUTPUT.set(False))
            if is_accepted(outcome):
                self.memory.clear()
                break
        _log.debug("the stream is off: %s", outcome)
        self.on_at = None
