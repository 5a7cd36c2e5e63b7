"""Two different answers to one question: two modules on this line, or another one than before.

Only the boot count and the settings that can be read are compared: they change by a set or a restart only. A frame that
may be old, or the acknowledgement of a set, is not compared for a while after that set.
"""

from math import inf

from protocol.catalogue import BOOT_COUNT, SETTINGS, Command, Request
from protocol.events import Contradiction, EndReason
from protocol.messages import Message, Reading
from protocol.timing import REPEATED_S

LASTING = frozenset((BOOT_COUNT, *(command for command in SETTINGS if command.reads_back)))
MAX_STARTS = 3
"""A module starts no more often between two of its answers; 256 starts are counted."""


class ToldValues:
    """What the module last told of each lasting value. Times are the link's `now`."""

    def __init__(self) -> None:
        self._told: dict[Command, Reading] = {}
        self._set_at: dict[Command, float] = {}
        self.twice_at = -inf
        """When a value was last told that nobody had asked for: a question was answered twice."""

    def forget(self) -> None:
        """Another conversation begins."""
        self._told.clear()

    def is_answered_twice(self, now: float) -> bool:
        """Whether that was a moment ago: there may be two modules on this line that tell the same."""
        return now - self.twice_at <= REPEATED_S

    def on_sent(self, request: Request, now: float) -> None:
        if request.is_set and request.command in LASTING:
            self._told.pop(request.command, None)
            self._set_at[request.command] = now

    def note_unasked(self, message: Message, now: float) -> None:
        """Note a value that nobody waits for; not what may acknowledge a set."""
        if not isinstance(message, Reading) or not message.command.can_be_asked:
            return
        if not self._was_set(message.command, now):
            self.twice_at = now

    def _was_set(self, command: Command, now: float) -> bool:
        """Whether it was set a moment ago, so that a frame may be older, or the acknowledgement."""
        set_at = self._set_at.get(command)
        return set_at is not None and now - set_at <= REPEATED_S

    def contradicted(self, message: Message, now: float, *, is_answer: bool) -> Contradiction | None:
        """Whether `message` says otherwise than what was told before. `is_answer`: to the question in flight, so it is
        newer than a set."""
        if not isinstance(message, Reading) or message.command not in LASTING:
            return None
        if not is_answer and self._was_set(message.command, now):
            return None
        before = self._told.get(message.command)
        if before is None:
            if is_answer:
                self._told[message.command] = message
            return None
        return None if before.raw == message.raw else Contradiction(before, message)


def reason_of(contradiction: Contradiction, *, is_asked: bool) -> EndReason:
    """A boot count that grew a little is a restart whose heartbeats were lost; not where one question was answered
    twice, so that it came unasked."""
    before, after = contradiction
    starts = (after.raw - before.raw) % 256
    if is_asked and after.command is BOOT_COUNT and starts <= MAX_STARTS:
        return EndReason.RESTARTED
    return EndReason.CONTRADICTED
