"""Status reports for a guided test, streamed or polled, and the waiting for the person."""

from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from math import inf

from app.engine.device import MAX_LAG_S, DeviceView, StatusSample
from app.engine.procedure import Ask, Await, EngineView, Inspect, Listen, Pause, Procedure
from app.guided.results import GuidedResult
from app.procedures.who_is_there import who_is_there
from app.procedures.write import read_back
from app.text.messages import message
from app.text.user_error import UserError
from protocol.catalogue import BY_NAME, HEARTBEAT, STATUS
from protocol.events import Answered, Received, Role
from protocol.fields import Value
from protocol.link_states import Presence
from protocol.messages import Status
from protocol.translatable import marked

LISTEN_S = 0.05
ASK_EVERY_S = 0.015
ASK_WAITS_S = (0.25,)
ANCHOR_EVERY_S = 0.5
"""While the module streams it is asked a question this often: only answers prove that the reports are current."""
AGREEING = 2
"""Reports in a row that must agree before they count."""
SILENT_S = 2.0
"""Without a report for this long the test is aborted."""
PERSON_LIMIT_S = 120.0
"""For one step of the person; then the test is aborted."""
NOT_READ = marked("Unknown: {what}.")


@dataclass(slots=True)
class PersonSteps:
    """Lets a procedure wait for a step of the person, which the window confirms. Thread-safe."""

    _asked: "Future[None] | None" = field(default=None)

    @property
    def is_waiting(self) -> bool:
        asked = self._asked
        return asked is not None and not asked.done()

    def ask(self) -> "Future[None]":
        asked: Future[None] = Future()
        self._asked = asked
        return asked

    def confirm(self) -> None:
        """The person has done the step. Does nothing if none is waited for."""
        asked = self._asked
        if asked is not None and not asked.done():
            asked.set_result(None)


Measure = Callable[[PersonSteps], Procedure[GuidedResult]]


def wait_for_person(steps: PersonSteps) -> Procedure[None]:
    """Wait until the step is confirmed; other procedures use the line meanwhile."""
    is_done = yield Await(steps.ask(), PERSON_LIMIT_S)
    if not is_done:
        raise _out_of_time()


def require_in_time(began: float, now: float) -> None:
    """Raise `UserError` if the person took too long for a step that began then."""
    if now - began > PERSON_LIMIT_S:
        raise _out_of_time()


def _out_of_time() -> UserError:
    return UserError(marked("No step within {seconds:.0f} s."), seconds=PERSON_LIMIT_S)


@dataclass(slots=True)
class StatusWatch:
    """Reads the reports; aborts the test when the module is not in the state that the test needs.

    `is_active`: the state that it must report; `may_trigger`: a reported trigger is part of the test.
    """

    begin: DeviceView
    is_active: bool = False
    may_trigger: bool = False
    _heard_at: float | None = None
    _anchored_at: float = -inf
    _against: int = 0
    """Reports in a row that contradict: a single one may be a damaged frame."""

    def next_reports(self) -> Procedure[tuple[StatusSample, ...]]:
        """Reports since the last call; may be empty."""
        view: EngineView = yield Inspect()
        require_start(view, self.begin)
        reports: tuple[StatusSample, ...] = ()
        if view.now - self._anchored_at > ANCHOR_EVERY_S:
            self._anchored_at = view.now
            yield Ask(HEARTBEAT.query(), ASK_WAITS_S, attempts=1)
        if view.device.is_streaming:
            heard: tuple[Received, ...] = yield Listen(LISTEN_S)
            reports = tuple(
                StatusSample(received.at, *received.message)
                for received in heard
                if isinstance(received.message, Status) and received.role in (Role.STREAMED, Role.ANSWER)
            )
        else:
            yield Pause(ASK_EVERY_S)
        if not reports:
            outcome = yield Ask(STATUS.query(), ASK_WAITS_S, attempts=1)
            if isinstance(outcome, Answered):
                reports = tuple(
                    StatusSample(outcome.at, *answer) for answer in outcome.messages if isinstance(answer, Status)
                )
            view = yield Inspect()
        self._check(reports, view.now)
        return reports

    def _check(self, reports: tuple[StatusSample, ...], now: float) -> None:
        if self._heard_at is None or reports:
            self._heard_at = now
        if now - self._heard_at > SILENT_S:
            raise UserError(marked("The module does not answer."))
        for report in reports:
            is_other = report.active is not self.is_active
            is_against = is_other or (report.triggered and not self.may_trigger)
            self._against = self._against + 1 if is_against else 0
            if self._against < AGREEING:
                continue
            if not is_other:
                raise UserError(marked("The module reports that it has fired."))
            if self.is_active:
                raise UserError(marked("The module was locked."))
            raise UserError(marked("ACTIVE during the test."))


def require_start(view: EngineView, begin: DeviceView) -> None:
    """Raise `UserError` if the module restarted or was silent since, is silent or answers late."""
    if view.device.restarts != begin.restarts:
        raise UserError(marked("The module restarted."))
    if view.device.presence is Presence.OFFLINE:
        raise UserError(marked("The module does not answer."))
    if view.device.breaks != begin.breaks:  # another module may have taken its place
        raise UserError(marked("No result: {why}."), why=message(marked("no reply for a moment")))
    if view.device.is_late:
        raise UserError(marked("Data arrives {seconds:.1f} s late."), seconds=MAX_LAG_S)


def require_locked() -> Procedure[DeviceView]:
    """Raise `UserError` unless the module now reports that it is locked and has not fired."""
    present = yield from who_is_there()
    if present.contradiction is not None:
        raise UserError(present.contradiction)
    view: EngineView = yield Inspect()
    active, triggered = (view.device.proven(key, view.now) for key in ("active", "triggered"))
    if active is None or triggered is None:
        raise UserError(marked("No current status."))
    if active.value:
        raise UserError(marked("The module is ACTIVE: lock it first."))
    if triggered.value:
        raise UserError(marked("The module reports that it has fired."))
    require_start(view, view.device)
    return view.device


def read_setting(name: str) -> Procedure[float]:
    """Read a threshold, twice the same. Raises `UserError`."""
    command = BY_NAME[name]
    back = yield from read_back(command)
    if back.raw is None or command.reply is None:
        raise UserError(NOT_READ, what=message(command.title))
    value: Value = command.reply.decode(back.raw)
    return float(value)
