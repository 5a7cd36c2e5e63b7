"""LOCK without a line: what the module reports is scripted, and what the procedure asks for is noted."""

from collections.abc import Callable
from typing import Any

from app.engine.procedure import MAX_LOCKS, Ask, Effect, Inspect, LockRepeat, Pause, Report, UseRate
from app.procedures.lock import QUESTIONS, Locked, lock
from protocol.catalogue import BY_NAME, LOCK, Request
from protocol.events import Answered, Unanswered
from protocol.messages import Acknowledgement, Reading
from tests.support.journals import FakeJournal
from tests.support.line.sim_line import engine_view


class LockScript:
    """Runs `lock` without a line. `answer` gives what the module reports at a time: active, locked or nothing."""

    def __init__(self, answer: Callable[[float], bool | None], proven_rate: int | None, *, is_searched: bool) -> None:
        self.now = 0.0
        self.repeat = LockRepeat()
        self.asked: list[tuple[float, Request]] = []
        self.rates: list[tuple[float, int]] = []
        self.progress: list[tuple[int, int]] = []
        self.withheld = self.asked_after = 0
        self._has_ended = False
        self._answer = answer
        self._proven_rate, self._is_searched = proven_rate, is_searched

    def run(self, journal: FakeJournal | None = None) -> Locked:
        procedure, result = lock(journal, self.repeat), None
        try:
            for _ in range(3000):
                result = self._result(procedure.send(result))
        except StopIteration as ended:
            locked: Locked = ended.value
            return locked
        raise AssertionError("it does not end")

    def _result(self, effect: Effect) -> Any:
        match effect:
            case Inspect():
                self._has_ended = not self.repeat.is_repeating(self.now)
                return engine_view(self.now, proven_rate=self._proven_rate, is_rate_searched=self._is_searched)
            case Ask():
                return self._reply(effect)
            case UseRate(rate):
                self.rates.append((self.now, rate))
            case Report(done, total) if total == MAX_LOCKS:
                self.progress.append((done, self.repeat.sent))
            case Pause(seconds):
                self.now += seconds
        return self.now

    def _reply(self, ask: Ask) -> Answered | Unanswered:
        if ask.request == LOCK and self.withheld:
            self.withheld -= 1
            return Unanswered(LOCK, 0, 0.0, self.now)
        if ask.request == LOCK:
            self.repeat.note_sent(self.now)
            if self._answer(self.now) is None:
                return Unanswered(LOCK, 1, 0.0, self.now)
            return Answered(LOCK, (Acknowledgement(LOCK, 0),), 1, 0.01, self.now)
        active = self._answer(self.now) if ask.request in QUESTIONS else None
        if ask.request in QUESTIONS:
            assert ask.attempts == 1, "LOCK is repeated meanwhile"
            self.asked.append((self.now, ask.request))
            self.asked_after += self._has_ended
        self.now += 0.3 if active is None else 0.01
        if ask.repeat is not None and active is None and self.repeat.is_due(self.now):
            self.repeat.note_sent(self.now)
        if active is None:
            return Unanswered(ask.request, 1, 0.3, self.now)
        return Answered(ask.request, (Reading(BY_NAME["active"], int(active)),), 1, 0.01, self.now)
