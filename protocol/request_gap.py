"""Quiet time before a request: some modules need a pause after a reply before they listen again.

Quiet means that neither side sends; streamed reports do not count. Questions start without a pause, as a lost one is
repeated; where quick ones are lost one after the other, those of this connection wait from then on. Sets and acts are
sent only once, so they always wait. LOCK never does.

A module on a half-duplex line does not receive while it is sending. So sets, acts and repeated questions are sent
directly after a streamed report, before the next one is due.
"""

from collections import deque
from math import inf

from protocol.catalogue import LOCK, Request

ONCE_S = 0.05
"""Before a set or an act."""
QUESTION_S = 0.032
"""Before a question, once `LOST_IN_A_ROW` quick ones were answered only when repeated."""
LOST_IN_A_ROW = 3
MAX_S = 0.2
"""The longest time for which a request is delayed."""
MAX_INTERVALS = 8
CLEAR_S = 0.004
"""The time that a request and the start of its reply need before the next streamed report."""
STREAM_LATE_S = 0.01
"""How long to wait for a streamed report that is late."""
SAME_READ_S = 0.0005


class Gap:
    """See the module's docstring. Times are the link's `now`."""

    def __init__(self) -> None:
        self._spoken_at = -inf
        self._attempts = 0
        """Of the request in flight."""
        self._lost_in_a_row = 0
        self.question_s = 0.0
        """The pause before a question, once it was learnt."""
        self._streamed_at = -inf
        self._intervals: deque[float] = deque(maxlen=MAX_INTERVALS)

    def due(self, request: Request, since: float, *, is_repeated: bool, now: float) -> float:
        """When `request` may be sent: at `since`, or at most `MAX_S` later."""
        if request == LOCK:
            return since
        ready_at = self._spoken_at + (self.question_s if request.is_repeatable else ONCE_S)
        if is_repeated or not request.is_repeatable:
            ready_at = self._between_reports(max(now, since, ready_at))
        return max(since, min(ready_at, since + MAX_S))

    def _between_reports(self, at: float) -> float:
        """`at`, or later where a streamed report is due."""
        if not self._intervals or self._streamed_at == at:
            return at
        next_at = self._streamed_at + min(self._intervals)
        if at < next_at - CLEAR_S:
            return at
        return max(at, next_at + STREAM_LATE_S)

    def on_spoken(self, now: float) -> None:
        """Note a frame of either side that is not a streamed report."""
        self._spoken_at = now

    def on_streamed(self, now: float) -> None:
        interval_s = now - self._streamed_at
        if interval_s > 1.0:
            self._intervals.clear()
        elif interval_s > SAME_READ_S:
            self._intervals.append(interval_s)
        self._streamed_at = now

    def sent(self, *, is_repeated: bool, now: float) -> None:
        self._attempts = self._attempts + 1 if is_repeated else 1
        self._spoken_at = now

    def answered(self) -> None:
        """Note that the request in flight was answered. Nothing is learnt from unanswered ones: the module may not know
        them, or may be absent."""
        self._lost_in_a_row = self._lost_in_a_row + 1 if self._attempts > 1 else 0
        if self._lost_in_a_row == LOST_IN_A_ROW:
            self.question_s = QUESTION_S
