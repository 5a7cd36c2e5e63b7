"""What must not be taken for the answer to a request: late and doubled replies, copies of the acknowledgements of 16
and 17, and values that another module tells."""

from collections import deque
from math import inf
from typing import NamedTuple

from protocol.catalogue import (
    ATTITUDE_TRIGGER,
    BOOT_COUNT,
    BY_NAME,
    FREEFALL_TRIGGER,
    HEARTBEAT,
    READABLE_SETTINGS,
    STATUS,
    Command,
    Layout,
    Request,
)
from protocol.events import Contradiction
from protocol.messages import Message, Reading, answers
from protocol.timing import DOUBLED_S, LATE_S, REPEATED_S

# Questions, of which one goes first where an earlier reply could be mistaken for an answer; so many, as a search for
# the baud rate leaves several unanswered. No heartbeat: one may come unasked.
FENCES = (
    BOOT_COUNT.query(),
    *(BY_NAME[name].query() for name in ("charging", "active", "triggered", "light")),
    *(command.query() for command in READABLE_SETTINGS),
)
_MAX_EXPECTED = 64
_MAX_COPIED = 8
TRIGGER_FLAGS = (FREEFALL_TRIGGER, ATTITUDE_TRIGGER)  # in the order in which they are set without a wait between them
FLAG_CODES = frozenset(command.code for command in TRIGGER_FLAGS)
LASTING = frozenset((BOOT_COUNT, *READABLE_SETTINGS))


class Owed(NamedTuple):
    """A request that was sent at `at`, whose reply may still come."""

    request: Request
    at: float


class Copied(NamedTuple):
    """A frame of which copies may follow. `request`: what it answered, if anything."""

    raw: bytes
    request: Request | None
    until: float
    is_late: bool


def _overlap(request: Request, other: Request) -> bool:
    return bool(request.command.reply_codes & other.command.reply_codes)


class StaleReplies:
    """Earlier requests whose replies may still arrive. Times are the link's `now`.

    Replies come in the order of the requests. A late one is expected for `LATE_S`, a copy for `DOUBLED_S`; only the
    answer to a later request proves that none can follow. All this is the line's, so it outlives a conversation: else a
    late answer to an old question would be the next one's.
    """

    def __init__(self) -> None:
        self._owed: deque[Owed] = deque(maxlen=_MAX_EXPECTED)
        # Requests to which a (further) reply may still come, however late, and when they were last sent.
        self._not_past: dict[Request, float] = {}
        self._copied: deque[Copied] = deque(maxlen=_MAX_COPIED)

    def expect_late(self, request: Request, sent_at: float, *, count: int) -> None:
        """Note that `count` replies to it may still come, and some time perhaps a further one."""
        self._owed.extend([Owed(request, sent_at)] * count)
        self._not_past[request] = sent_at

    def expect_copy(self, raw: bytes, request: Request | None, now: float, *, is_late: bool = False) -> None:
        """Note that a copy of this frame, the answer to `request`, may follow at once."""
        self._copied.appendleft(Copied(raw, request, now + DOUBLED_S, is_late))

    def drop_expired(self, now: float) -> None:
        while self._owed and now - self._owed[0].at > LATE_S:
            self._owed.popleft()

    def copied(self, raw: bytes, now: float) -> Copied | None:
        """The frame of which this is a copy."""
        return next((copy for copy in self._copied if copy.raw == raw and now <= copy.until), None)

    def is_owed(self, raw: bytes) -> bool:
        """Whether an earlier question may still be answered by this frame."""
        return any(answers(raw, owed.request) for owed in self._owed)

    def pop_late(self, raw: bytes) -> Owed | None:
        # The oldest, as replies come in the order of the requests.
        late = next((owed for owed in self._owed if answers(raw, owed.request)), None)
        if late is not None:
            self._owed.remove(late)
        return late

    def owes(self, request: Request) -> bool:
        """Whether the same question is still to be answered. Its answer would be taken for the next one's, and so on
        for ever."""
        return any(owed.request == request for owed in self._owed)

    def could_be_late(self, request: Request, now: float) -> bool:
        """Whether the reply to an earlier request, also to the same question, could be taken for its answer."""
        return any(_overlap(earlier, request) for earlier in self._earlier(now))

    def could_answer(self, request: Request, now: float) -> bool:
        """Whether a reply to another request could be mistaken for the answer to this one. A reply to the same question
        asked before is as good."""
        is_plain_question = request.is_repeatable and request.command.layout is not Layout.RECORD
        for earlier in [*self._not_past, *self._copied_requests(now)]:
            is_as_good = is_plain_question and earlier == request
            if not is_as_good and _overlap(earlier, request):
                return True
        return False

    def fence(self, now: float) -> Request:
        """A question whose answer no earlier reply can be mistaken for."""
        earlier = [*self._earlier(now), *self._copied_requests(now)]
        free = (fence for fence in FENCES if not any(_overlap(request, fence) for request in earlier))
        return next(free, FENCES[0])

    def opens(self, fence: Request, raw: bytes, now: float) -> bool:
        """Whether this is the fence's own answer, and not a late or doubled one to an earlier question."""
        return self.copied(raw, now) is None and not any(_overlap(owed.request, fence) for owed in self._owed)

    def on_answered(self, answered: Request, asked_at: float, now: float) -> None:
        """Note the answer to `answered`: no reply to a request before `asked_at` can follow."""
        if answered.command in (STATUS, HEARTBEAT):
            return  # it may have been streamed, or be a restart's
        if self.could_be_late(answered, now):
            # If it was the late reply to the same question asked before, the one to this question is still to come.
            same = next((owed for owed in self._owed if owed.request == answered), None)
            if same is not None:
                self._owed.remove(same)
                self._owed.append(Owed(answered, now))
            return
        self._not_past = {request: at for request, at in self._not_past.items() if at >= asked_at}
        self._owed = deque((owed for owed in self._owed if owed.at >= asked_at), maxlen=_MAX_EXPECTED)
        while len(self._copied) > 1:
            self._copied.pop()  # no copy of an earlier frame can follow either

    def _earlier(self, now: float) -> list[Request]:
        """Requests that may still be answered in time to count as late."""
        recent = [request for request, at in self._not_past.items() if now - at <= LATE_S]
        return [*recent, *(owed.request for owed in self._owed)]

    def _copied_requests(self, now: float) -> list[Request]:
        return [copy.request for copy in self._copied if copy.request is not None and now <= copy.until]


class FlagAnswers:
    """When 16 and 17 may be set, and when their answers are known (E4). Belongs to the line, as `StaleReplies` does.

    The acknowledgement of 17 may come under 16, and neither can be asked for. So on a line that repeats what it passes
    on (some bridges do, up to seconds later) a copy of one acknowledgement looks like the other one, which never came.
    Time tells them apart:

    - A set waits until no answer to an earlier one can come any more, also after an acknowledgement, and after the port
      was opened, as an earlier program may have set them. The one exception is 16 directly after a 17 that was answered
      under 17: no copy of that answer can be taken for the answer to 16.
    - What was acknowledged counts only after a further wait without a frame of either.
    - Where an acknowledgement came twice nothing counts in this conversation: this line repeats answers.
    """

    def __init__(self, now: float) -> None:
        self._opened_at = now
        self._last_at = -inf  # when the last frame of either was sent or came
        self._is_told_apart = False  # the last one was a 17 that was answered under 17
        self.has_repeated = False  # an acknowledgement came twice

    def free_at(self, request: Request) -> float:
        """When `request` may be sent; at any time if it sets neither of them."""
        if request.command not in TRIGGER_FLAGS:
            return -inf
        if request.command is ATTITUDE_TRIGGER and self._is_told_apart:
            return -inf
        return max(self._opened_at, self._last_at) + LATE_S

    def are_known(self, now: float) -> bool:
        """Whether what was acknowledged counts."""
        return not self.has_repeated and now >= self._last_at + LATE_S

    def on_sent(self, request: Request, now: float) -> None:
        if request.command in TRIGGER_FLAGS:
            self._note(now)

    def on_answer(self, request: Request, raw: bytes, now: float) -> None:
        """Note the acknowledgement of the set in flight."""
        self._note(now)
        self._is_told_apart = request.command is FREEFALL_TRIGGER and raw[2] == FREEFALL_TRIGGER.code

    def on_other(self, now: float, *, is_late: bool) -> None:
        """Note a frame of theirs that nobody waits for: a late answer, or else a copy."""
        self._note(now)
        self.has_repeated |= not is_late

    def begin_again(self) -> None:
        self.has_repeated = False
        self._is_told_apart = False

    def _note(self, now: float) -> None:
        self._last_at = now
        self._is_told_apart = False


class LastingValues:
    """It keeps what the module last told of each lasting value: two different answers to one question come from two
    modules on this line, or another one than before. Times are the link's `now`.

    Only the boot count and the settings that can be read are compared: they change by a set or a restart only. A frame
    that may be old, or the acknowledgement of a set, is not compared for a while after that set.
    """

    def __init__(self) -> None:
        self._told: dict[Command, Reading] = {}
        self._set_at: dict[Command, float] = {}
        self.twice_at = -inf  # when a value was last told that nobody had asked for: a question was answered twice

    def forget(self) -> None:
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
        # Whether it was set a moment ago, so that a frame may be older, or the acknowledgement.
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
            # What came unasked may be another module's: nothing is compared with it.
            if is_answer:
                self._told[message.command] = message
            return None
        return None if before.raw == message.raw else Contradiction(before, message)
