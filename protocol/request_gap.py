"""Minimum quiet time before a request, learnt from losses: some modules need a pause after a reply.

Quiet means that neither side sends; streamed reports do not count. Questions start without a pause. Where questions
soon after a reply are lost clearly more often than those after a longer pause, the pause grows; after many answers a
shorter one is tried again. Sets and acts are sent only once, so they always wait a little, and longer until a request
after a short pause has been answered. LOCK never waits.

A module on a half-duplex line does not receive while it is sending. So sets, acts and repeated questions are sent
directly after a streamed report, before the next one is due.
"""

from collections import deque
from math import inf

from protocol.catalogue import LOCK, Request

ONCE_S = 0.015
"""Before a set or an act, once a request after a pause this short has been answered."""
ONCE_UNTRIED_S = 0.05
"""The same until then."""
PAUSES_S = (0.0, 0.008, 0.016, 0.032, 0.064)
"""The pauses before questions, shortest first."""
MAX_S = 0.2
"""The longest time for which a request is delayed."""
MAX_OUTCOMES = 8
"""Outcomes kept for each pause."""
LOST_AT_LEAST = 3
LOST_SHARE = 0.75
LOST_MORE = 0.5
"""A pause is too short where this many and this share of the requests were lost, and this much more than after longer
pauses."""
PATIENCE, LONGEST_PATIENCE = 200, 6400
"""Answers until a shorter pause is tried; doubled with each try, as a try may lose questions."""
CLEAR_S = 0.004
"""The time that a request and the start of its reply need before the next streamed report."""
ROUNDING_S = 1e-4
STREAM_LATE_S = 0.01
"""How long to wait for a streamed report that is late."""
SAME_READ_S = 0.0005


class Gap:
    """See the module's docstring. Times are the link's `now`."""

    def __init__(self) -> None:
        self._spoken_at = -inf
        self._pauses: list[float] = []
        """Before each attempt of the request in flight."""
        self._outcomes: list[deque[bool]] = [deque(maxlen=MAX_OUTCOMES) for _ in PAUSES_S]
        """For each pause up to the next longer one: whether requests were answered."""
        self._step = 0
        self._answers = 0
        self._patience = PATIENCE
        self._streamed_at = -inf
        self._intervals: deque[float] = deque(maxlen=MAX_OUTCOMES)

    @property
    def question_s(self) -> float:
        return PAUSES_S[self._step]

    @property
    def once_s(self) -> float:
        """The pause before a set or an act."""
        tried = (self._outcomes[step] for step, pause_s in enumerate(PAUSES_S) if pause_s < ONCE_S)
        is_tried = any(True in outcomes and not _mostly_lost(outcomes) for outcomes in tried)
        return max(self.question_s, ONCE_S if is_tried else ONCE_UNTRIED_S)

    def due(self, request: Request, since: float, *, is_repeated: bool, now: float) -> float:
        """When `request` may be sent: at `since`, or at most `MAX_S` later."""
        if request == LOCK:
            return since
        if request.is_repeatable and not is_repeated:
            ready_at = self._spoken_at + self.question_s
        else:
            quiet_s = self.question_s if request.is_repeatable else self.once_s
            ready_at = self._between_reports(max(now, since, self._spoken_at + quiet_s))
        return max(since, min(ready_at, since + MAX_S))

    def _between_reports(self, at: float) -> float:
        """`at`, or later where a streamed report is due."""
        if not self._intervals or self._streamed_at == at:
            return at
        next_at = self._streamed_at + min(self._intervals)
        return at if at < next_at - CLEAR_S else max(at, next_at + STREAM_LATE_S)

    def on_reply(self, now: float) -> None:
        """Note a frame that is not a streamed report."""
        self._spoken_at = now

    def on_streamed(self, now: float) -> None:
        interval_s = now - self._streamed_at
        if interval_s > 1.0:
            self._intervals.clear()
        elif interval_s > SAME_READ_S:
            self._intervals.append(interval_s)
        self._streamed_at = now

    def sent(self, *, is_repeated: bool, now: float) -> None:
        if not is_repeated:
            self._pauses.clear()
        self._pauses.append(now - self._spoken_at)
        self._spoken_at = now

    def answered(self) -> None:
        """Note that the request in flight was answered: presumably its last attempt, and none before.

        Nothing is learnt from unanswered requests: the module may not know them, or may be absent.
        """
        *lost, heard = self._pauses or [inf]
        for pause_s in lost:
            self._outcomes[_step_of(pause_s)].append(False)
        self._outcomes[_step_of(heard)].append(True)
        self._answers += 1
        self._adapt()

    def _adapt(self) -> None:
        if self._step and self._answers >= self._patience:
            self._outcomes[self._step - 1].clear()
            self._answers = 0
        too_short = [step for step in range(len(PAUSES_S) - 1) if self._is_too_short(step)]
        step = too_short[-1] + 1 if too_short else 0
        if step < self._step:
            self._patience = min(LONGEST_PATIENCE, 2 * self._patience)
        elif step > self._step:
            self._answers = 0
        self._step = step

    def _is_too_short(self, step: int) -> bool:
        outcomes = self._outcomes[step]
        if outcomes.count(False) < LOST_AT_LEAST or not _mostly_lost(outcomes):
            return False
        longer = [is_answered for outcomes in self._outcomes[step + 1 :] for is_answered in outcomes]
        return bool(longer) and _lost(outcomes) >= _lost(longer) + LOST_MORE


def _step_of(pause_s: float) -> int:
    return max(step for step, least_s in enumerate(PAUSES_S) if pause_s + ROUNDING_S >= least_s)


def _lost(outcomes: "deque[bool] | list[bool]") -> float:
    return sum(not is_answered for is_answered in outcomes) / len(outcomes)


def _mostly_lost(outcomes: "deque[bool]") -> bool:
    return bool(outcomes) and _lost(outcomes) >= LOST_SHARE
