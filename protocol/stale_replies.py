"""Earlier requests whose replies may still arrive and must not be taken for an answer.

Replies come in the order of the requests. A late one is expected for `Timing.late_s`, a copy for `Timing.doubled_s`;
only the answer to a later request proves that none can follow.
"""

from collections import deque
from math import inf
from typing import NamedTuple

from protocol.catalogue import BY_NAME, HEARTBEAT, STATUS, Layout, Request
from protocol.messages import answers
from protocol.round_trips import Timing

_HEARTBEAT = HEARTBEAT.query()
FENCES = (_HEARTBEAT, *(BY_NAME[name].query() for name in ("boot_count", "charging", "active", "triggered")))
"""Questions whose answers cannot be mistaken for the reply to a set."""
_MAX_EXPECTED = 64
_MAX_COPIED = 8


class _Outstanding(NamedTuple):
    """A request whose reply may still come."""

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

    def __init__(self, timing: Timing) -> None:
        self._timing = timing
        self._outstanding: deque[_Outstanding] = deque(maxlen=_MAX_EXPECTED)
        self._not_past: list[Request] = []
        """Requests to which a (further) reply may still come, oldest first."""
        self._copied: deque[Copied] = deque(maxlen=_MAX_COPIED)
        self._heartbeats_at = (-inf, -inf)
        """When the last two came, the last one first."""

    def expect_late(self, request: Request, now: float, *, count: int) -> None:
        """Note that `count` replies to it may still come."""
        self._outstanding.extend([_Outstanding(request, now)] * count)
        self.remember(request)

    def remember(self, request: Request) -> None:
        """Note that it may be answered again."""
        if request not in self._not_past:
            self._not_past.append(request)

    def drop_expired(self, now: float) -> None:
        while self._outstanding and now - self._outstanding[0].at > self._timing.late_s:
            self._outstanding.popleft()

    def could_answer(self, request: Request, now: float) -> bool:
        """Whether a reply to another request could be mistaken for the answer to this one. A reply to the same question
        asked before is as good."""
        repeats = request.is_repeatable and request.command.layout is not Layout.RECORD
        copied = [copy.request for copy in self._copied if copy.request is not None and now <= copy.until]
        others = (other for other in (*self._not_past, *copied) if not (repeats and other == request))
        return any(_overlap(other, request) for other in others)

    def fence(self, now: float, *, is_proof: bool = False) -> Request:
        """A heartbeat, or another question where an earlier reply or a restart's second heartbeat could be mistaken for
        its answer. With `is_proof` not a heartbeat: one may come unasked at any time."""
        requests = self._all()
        requests += tuple(copy.request for copy in self._copied if copy.request is not None and now <= copy.until)
        if is_proof or now - self._heartbeats_at[0] <= self._timing.restart_s:
            requests += (_HEARTBEAT,)
        told_apart = (fence for fence in FENCES if not any(_overlap(request, fence) for request in requests))
        return next(told_apart, _HEARTBEAT)

    def on_heartbeat(self, now: float) -> None:
        self._heartbeats_at = now, self._heartbeats_at[0]

    def opens(self, fence: Request, raw: bytes, now: float) -> bool:
        """Whether this is the fence's own answer, and not a late or doubled one to an earlier question."""
        return self.copied(raw, now) is None and not any(_overlap(owed.request, fence) for owed in self._outstanding)

    def on_answered(self, answered: Request, now: float) -> None:
        """Note the answer to `answered`: no reply to an earlier request can follow."""
        if answered.command is STATUS:
            return  # it may have been streamed
        if answered == _HEARTBEAT and self._heartbeats_at[0] - self._heartbeats_at[1] <= self._timing.restart_s:
            return  # it may be the second one of a restart
        if any(_overlap(earlier, answered) for earlier in self._all()):
            self._renew(answered, now)
            return  # it may be a late or doubled answer to an earlier one
        self._not_past.clear()
        self._outstanding.clear()
        while len(self._copied) > 1:
            self._copied.pop()  # no copy of an earlier frame can follow either

    def _renew(self, answered: Request, now: float) -> None:
        """If it was the late reply to the same question asked before, the one to this question is still to come."""
        owed = next((reply for reply in self._outstanding if reply.request == answered), None)
        if owed is not None:
            self._outstanding.remove(owed)
            self._outstanding.append(_Outstanding(answered, now))

    def _all(self) -> tuple[Request, ...]:
        return (*self._not_past, *[owed.request for owed in self._outstanding])

    def pop_late(self, raw: bytes) -> Request | None:
        """Remove and return the oldest request to which this frame is a late reply."""
        for owed in self._outstanding:
            if answers(raw, owed.request):
                self._outstanding.remove(owed)
                return owed.request
        return None

    def is_owed(self, raw: bytes) -> bool:
        """Whether an earlier question may still be answered by this frame."""
        return any(answers(raw, owed.request) for owed in self._outstanding)

    def expect_copy(self, raw: bytes, request: Request | None, now: float, *, is_late: bool = False) -> None:
        """Note that a copy of this frame, the answer to `request`, may follow at once."""
        self._copied.appendleft(Copied(raw, request, now + self._timing.doubled_s, is_late))

    def expect_no_copy(self, raw: bytes) -> None:
        """Undo `expect_copy`."""
        self._copied = deque((copy for copy in self._copied if copy.raw != raw), maxlen=_MAX_COPIED)

    def copied(self, raw: bytes, now: float) -> Copied | None:
        """The frame of which this is a copy."""
        return next((copy for copy in self._copied if copy.raw == raw and now <= copy.until), None)
