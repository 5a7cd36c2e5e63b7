"""When 16 and 17 may be set, and when their answers are known (E4).

The acknowledgement of 17 may come under 16, and neither can be asked for. So on a line that repeats what it passes on
(some bridges do, up to seconds later) a copy of one acknowledgement looks like the other one, which never came. Time
tells them apart:

- A set waits until no answer to an earlier one can come any more, also after an acknowledgement, and after the port was
  opened, as an earlier program may have set them. The one exception is 16 directly after a 17 that was answered under
  17: no copy of that answer can be taken for the answer to 16.
- What was acknowledged counts only after a further wait without a frame of either.
- Where an acknowledgement came twice nothing counts in this conversation: this line repeats answers.
"""

from math import inf

from protocol.catalogue import ATTITUDE_TRIGGER, FREEFALL_TRIGGER, Request
from protocol.messages import answers
from protocol.timing import LATE_S

TRIGGER_FLAGS = (FREEFALL_TRIGGER, ATTITUDE_TRIGGER)
"""In the order in which they are set without a wait between them."""
FLAG_CODES = frozenset(command.code for command in TRIGGER_FLAGS)


class FlagAnswers:
    """See the module's docstring. It belongs to the line, so it outlives a conversation. Times are the link's `now`."""

    def __init__(self, now: float) -> None:
        self._free_at = now + LATE_S
        self._last_at = -inf
        """When the last frame of either was sent or came."""
        self._unanswered: list[Request] = []
        self._is_told_apart = False
        """The last one was a 17 that was answered under 17."""
        self.has_repeated = False
        """An acknowledgement came twice."""

    def free_at(self, request: Request) -> float:
        """When `request` may be sent; at any time if it sets neither of them."""
        if request.command not in TRIGGER_FLAGS:
            return -inf
        if request.command is ATTITUDE_TRIGGER and self._is_told_apart:
            return -inf
        return self._free_at

    def are_known(self, now: float) -> bool:
        """Whether what was acknowledged counts."""
        return not self.has_repeated and now >= self._last_at + LATE_S

    def on_sent(self, request: Request, now: float) -> None:
        if request.command in TRIGGER_FLAGS:
            self._note(now)
            self._unanswered.append(request)

    def on_answer(self, request: Request, raw: bytes, now: float) -> None:
        """Note the acknowledgement of the set in flight."""
        self._note(now)
        if request in self._unanswered:  # not after a restart
            self._unanswered.remove(request)
        self._is_told_apart = request.command is FREEFALL_TRIGGER and raw[2] == FREEFALL_TRIGGER.code

    def on_other(self, raw: bytes, now: float) -> None:
        """Note a frame of theirs that nobody waits for: a late answer, or a copy."""
        self._note(now)
        late = next((request for request in self._unanswered if answers(raw, request)), None)
        if late is not None:
            self._unanswered.remove(late)
        else:
            self.has_repeated = True

    def begin_again(self) -> None:
        """Another conversation begins on the same line."""
        self._unanswered.clear()
        self.has_repeated = False
        self._is_told_apart = False

    def _note(self, now: float) -> None:
        self._last_at = now
        self._free_at = now + LATE_S
        self._is_told_apart = False
