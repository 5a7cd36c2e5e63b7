"""Earlier requests whose replies may still arrive and must not be taken for an answer.

Replies come in the order of the requests. A late one is expected for `LATE_S`, a copy for `DOUBLED_S`; only the answer
to a later request proves that none can follow. All this is the line's, so it outlives a conversation: else a late
answer to an old question would be the next one's.
"""

from collections import deque
from math import inf
from typing import NamedTuple

from protocol.catalogue import BOOT_COUNT, BY_NAME, HEARTBEAT, SETTINGS, STATUS, Layout, Request
from protocol.messages import answers
from protocol.timing import DOUBLED_S, LATE_S, RESTART_S

_HEARTBEAT = HEARTBEAT.query()
FENCES = (
    BOOT_COUNT.query(),
    *(BY_NAME[name].query() for name in ("charging", "active", "triggered", "light")),
    *(command.query() for command in SETTINGS if command.reads_back),
)
"""Questions, of which one goes first where an earlier reply could be mistaken for an answer; so many, as a search for
the baud rate leaves several unanswered. No heartbeat: one may come unasked."""
_MAX_EXPECTED = 64
_MAX_COPIED = 8


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
    """See the module's docstring. Times are the link's `now`."""

    def __init__(self) -> None:
        self._owed: deque[Owed] = deque(maxlen=_MAX_EXPECTED)
        self._not_past: dict[Request, float] = {}
        """Requests to which a (further) reply may still come, however late, and when they were last sent."""
        self._copied: deque[Copied] = deque(maxlen=_MAX_COPIED)
        self._heartbeats_at = (-inf, -inf)
        """When the last two came, the last one first."""

    # What may still come

    def expect_late(self, request: Request, sent_at: float, *, count: int) -> None:
        """Note that `count` replies to it may still come."""
        self._owed.extend([Owed(request, sent_at)] * count)
        self.remember(request, sent_at)

    def remember(self, request: Request, sent_at: float) -> None:
        """Note that it may be answered again."""
        self._not_past[request] = sent_at

    def expect_copy(self, raw: bytes, request: Request | None, now: float, *, is_late: bool = False) -> None:
        """Note that a copy of this frame, the answer to `request`, may follow at once."""
        self._copied.appendleft(Copied(raw, request, now + DOUBLED_S, is_late))

    def expect_no_copy(self, raw: bytes) -> None:
        """Undo `expect_copy`."""
        self._copied = deque((copy for copy in self._copied if copy.raw != raw), maxlen=_MAX_COPIED)

    def drop_expired(self, now: float) -> None:
        while self._owed and now - self._owed[0].at > LATE_S:
            self._owed.popleft()

    # What a frame may be

    def copied(self, raw: bytes, now: float) -> Copied | None:
        """The frame of which this is a copy."""
        for copy in self._copied:
            if copy.raw == raw and now <= copy.until:
                return copy
        return None

    def is_owed(self, raw: bytes) -> bool:
        """Whether an earlier question may still be answered by this frame."""
        return any(answers(raw, owed.request) for owed in self._owed)

    def pop_late(self, raw: bytes) -> Owed | None:
        """Remove and return the oldest request to which this frame is a late reply."""
        for owed in self._owed:
            if answers(raw, owed.request):
                self._owed.remove(owed)
                return owed
        return None

    # What a question needs

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
        for fence in FENCES:
            if not any(_overlap(request, fence) for request in earlier):
                return fence
        return FENCES[0]

    def opens(self, fence: Request, raw: bytes, now: float) -> bool:
        """Whether this is the fence's own answer, and not a late or doubled one to an earlier question."""
        return self.copied(raw, now) is None and not any(_overlap(owed.request, fence) for owed in self._owed)

    # What an answer proves

    def on_heartbeat(self, now: float) -> None:
        self._heartbeats_at = now, self._heartbeats_at[0]

    def on_answered(self, answered: Request, asked_at: float, now: float) -> None:
        """Note the answer to `answered`: no reply to a request before `asked_at` can follow."""
        if answered.command is STATUS:
            return  # it may have been streamed
        if answered == _HEARTBEAT and self._heartbeats_at[0] - self._heartbeats_at[1] <= RESTART_S:
            return  # it may be the second one of a restart
        if self.could_be_late(answered, now):
            self._renew(answered, now)
            return  # it may be a late or doubled answer to an earlier one
        self._not_past = {request: at for request, at in self._not_past.items() if at >= asked_at}
        self._owed = deque((owed for owed in self._owed if owed.at >= asked_at), maxlen=_MAX_EXPECTED)
        while len(self._copied) > 1:
            self._copied.pop()  # no copy of an earlier frame can follow either

    def _renew(self, answered: Request, now: float) -> None:
        """If it was the late reply to the same question asked before, the one to this question is still to come."""
        for owed in self._owed:
            if owed.request == answered:
                self._owed.remove(owed)
                self._owed.append(Owed(answered, now))
                return

    def _earlier(self, now: float) -> list[Request]:
        """Requests that may still be answered in time to count as late."""
        recent = [request for request, at in self._not_past.items() if now - at <= LATE_S]
        return [*recent, *(owed.request for owed in self._owed)]

    def _copied_requests(self, now: float) -> list[Request]:
        return [copy.request for copy in self._copied if copy.request is not None and now <= copy.until]
