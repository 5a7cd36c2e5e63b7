"""Two different answers to one question: two modules on this line, or another one than before.

Only the boot count and the settings that can be read are compared: they change by a set or a restart only. Frames that
may be old, or the acknowledgement of a set, are not compared for a while after that set.
"""

from math import inf

from protocol.catalogue import BOOT_COUNT, SETTINGS, Command, Request
from protocol.messages import Message, Reading
from protocol.round_trips import Timing

LASTING = frozenset((BOOT_COUNT, *(command for command in SETTINGS if command.reads_back)))


class ToldValues:
    """What the module last told of each lasting value. Times are the link's `now`."""

    def __init__(self, timing: Timing) -> None:
        self._timing = timing
        self._told: dict[Command, Reading] = {}
        self._set_at: dict[Command, float] = {}
        self.since: float | None = None
        """When something was first told in this conversation. A second module has the vendor's second, too."""
        self.twice_at = -inf
        """When a value was last told that nobody had asked for: a question was answered twice."""

    def forget(self) -> None:
        """Another module may answer from now on, or this one after a restart."""
        self._told.clear()
        self.since = None

    def is_answered_twice(self, now: float) -> bool:
        """Whether that was a moment ago: there may be two modules on this line that tell the same."""
        return now - self.twice_at <= self._timing.repeated_s

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
        return set_at is not None and now - set_at <= self._timing.repeated_s

    def contradicted(self, message: Message, now: float, *, is_answer: bool) -> Reading | None:
        """What was told before, if `message` says otherwise.

        `is_answer`: to the question in flight. Another boot count is a restart then, which `Device` notices.
        """
        if is_answer and self.since is None:
            self.since = now
        if not isinstance(message, Reading) or message.command not in LASTING:
            return None
        command, before = message.command, self._told.get(message.command)
        if is_answer:
            self._told[command] = message
        if before is None or before.raw == message.raw or self._was_set(command, now):
            return None
        return None if is_answer and command is BOOT_COUNT else before
