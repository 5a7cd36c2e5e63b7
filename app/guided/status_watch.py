"""Status reports for a guided test, streamed or asked for, and the waiting for the person.

A test is of one conversation: an interruption ends it, so nothing here asks whether the module is still the same one.
"""

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from math import inf

from app.engine.conversation import StatusSample
from app.engine.procedure import TOO_SLOW, Await, EngineView, Inspect, Listen, Pause, Procedure, Report, ask_report
from app.guided.results import GuidedResult
from app.procedures.read import read_twice, who_is_there
from app.text.messages import UserError, message
from protocol.catalogue import BY_NAME
from protocol.events import Role
from protocol.messages import Status
from protocol.translatable import marked

LISTEN_S = 0.05
ASK_EVERY_S = 0.015
# Reports in a row that must agree before they count: a single one may be a damaged frame.
AGREEING = 2
# For one step of the person; then the test is aborted.
PERSON_LIMIT_S = 120.0
NOT_READ = marked("Unknown: {what}.")


class PersonSteps:
    """Lets a procedure wait for a step of the person, which the window confirms. Thread-safe."""

    def __init__(self) -> None:
        self._asked: Future[None] = Future()
        self._asked.set_result(None)

    @property
    def is_waiting(self) -> bool:
        return not self._asked.done()

    def ask(self) -> "Future[None]":
        self._asked = Future()
        return self._asked

    def confirm(self) -> None:
        """The person has done the step. Does nothing if none is waited for."""
        asked = self._asked
        if not asked.done():
            asked.set_result(None)


Measure = Callable[[PersonSteps], Procedure[GuidedResult]]


def wait_for_person(steps: PersonSteps) -> Procedure[None]:
    """Wait until the step is confirmed; other procedures use the line meanwhile."""
    is_done = yield Await(steps.ask(), PERSON_LIMIT_S)
    if not is_done:
        raise _out_of_time()


def _out_of_time() -> UserError:
    return UserError(marked("No step within {seconds:.0f} s."), seconds=PERSON_LIMIT_S)


class StatusWatch:
    """Hands out the reports one by one. Raises `UserError` when the module is not in the state that the test needs, or
    when a step, or all of it (`longest_s`), takes too long."""

    def __init__(self, *, is_active: bool, longest_s: float = inf) -> None:
        self._is_active, self._longest_s = is_active, longest_s
        self._waiting: deque[StatusSample] = deque()
        self._began_at: float | None = None
        self._step_began_at = 0.0
        self._against = 0

    def begin(self, step: Report) -> Procedure[None]:
        """Tell the person what to do now."""
        self._step_began_at = yield step
        if self._began_at is None:
            self._began_at = self._step_began_at

    def next(self) -> Procedure[StatusSample]:
        while not self._waiting:
            view: EngineView = yield Inspect()
            if view.now - self._step_began_at > PERSON_LIMIT_S:
                raise _out_of_time()
            if self._began_at is not None and view.now - self._began_at > self._longest_s:
                raise UserError(marked("Ended after {seconds:.0f} s."), seconds=self._longest_s)
            yield from self._gather(is_streaming=view.conversation.is_streaming)
        report = self._waiting.popleft()
        self._check(report)
        return report

    def _gather(self, *, is_streaming: bool) -> Procedure[None]:
        if is_streaming:
            for received in (yield Listen(LISTEN_S)):
                if isinstance(received.message, Status) and received.role in (Role.STREAMED, Role.ANSWER):
                    self._waiting.append(StatusSample(received.at, *received.message))
        else:
            yield Pause(ASK_EVERY_S)
        if not self._waiting:
            report = yield from ask_report()
            if report is not None:
                self._waiting.append(report)

    def _check(self, report: StatusSample) -> None:
        self._against = 0 if report.active is self._is_active else self._against + 1
        if self._against >= AGREEING:
            raise UserError(marked("The module was locked.") if self._is_active else marked("ACTIVE during the test."))


def require_locked() -> Procedure[None]:
    """Raise `UserError` unless the module now reports that it is locked and has not fired."""
    view: EngineView = yield Inspect()
    if view.conversation.is_slow:
        raise UserError(TOO_SLOW)
    present = yield from who_is_there()
    if present.contradiction is not None or present.status is None:
        raise UserError(present.contradiction or marked("No current status."))
    if present.status.active:
        raise UserError(marked("The module is ACTIVE: lock it first."))
    if present.status.triggered:
        raise UserError(marked("The module reports that it has fired."))


def read_setting(name: str) -> Procedure[float]:
    """Read a threshold, twice the same. Raises `UserError`."""
    command = BY_NAME[name]
    reading = yield from read_twice(command)
    if reading is None:
        raise UserError(NOT_READ, what=message(command.title))
    return float(reading.value)
