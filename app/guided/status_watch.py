"""Status reports for a guided test: streamed where the module streams, else asked for one after the other."""

from concurrent.futures import Future
from dataclasses import dataclass, field
from math import inf

from app.engine.device import LONGEST_LAG_S
from app.engine.playback import require_module
from app.engine.procedure import Ask, Await, EngineView, Inspect, Listen, Pause, Procedure
from app.guided.results import BreakOff
from app.procedures.ask_status import ask_status
from app.procedures.write import read_back
from app.text.messages import said
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
"""While it streams a question is asked so often: only answers prove that what comes is current."""
AGREEING = 2
"""Reports in a row that must say the same before it counts."""
SILENT_S = 2.0
"""Without a report for so long the test is broken off."""
PERSON_LIMIT_S = 120.0
"""For one step; then nobody is there any more."""
NOT_READ = marked("Could not be read: {what}.")
NOBODY = marked("No step within {seconds:.0f} s.")


@dataclass(frozen=True, slots=True, kw_only=True)
class GuidedSetup:
    """What a test goes by, read from the module before it."""

    restarts: int = 0
    attitude_threshold_deg: float = 0.0
    freefall_acceleration_g: float = 0.0
    freefall_time_s: float = 0.0
    light_threshold_v: float = 0.0
    tilt_deg: float = 0.0
    """Before zeroing."""


@dataclass(frozen=True, slots=True)
class StatusReport:
    """`at`: monotonic seconds at which it arrived."""

    at: float
    status: Status


@dataclass(slots=True)
class PersonSteps:
    """Where a procedure waits for the person: the procedure asks, the window confirms. For any thread."""

    _asked: "Future[None] | None" = field(default=None)

    @property
    def is_waiting(self) -> bool:
        """A step is to be confirmed by its button."""
        asked = self._asked
        return asked is not None and not asked.done()

    def ask(self) -> "Future[None]":
        asked: Future[None] = Future()
        self._asked = asked
        return asked

    def confirm(self) -> None:
        """The person has done the step; without one that waits it does nothing."""
        asked = self._asked
        if asked is not None and not asked.done():
            asked.set_result(None)

    def done(self) -> None:
        """The step was seen done: nobody needs to confirm it."""
        self._asked = None


def wait_for_person(steps: PersonSteps) -> Procedure[None]:
    """Until the step is confirmed; the line serves others meanwhile."""
    is_done = yield Await(steps.ask(), PERSON_LIMIT_S)
    if not is_done:
        raise BreakOff(NOBODY, seconds=PERSON_LIMIT_S)


@dataclass(slots=True)
class StatusWatch:
    """Hands on the reports; breaks the test off when the module is not as the test needs it.

    `is_active`: the state that it must report; `may_trigger`: a reported trigger is part of the test.
    """

    restarts: int
    is_active: bool = False
    may_trigger: bool = False
    _heard_at: float | None = None
    _anchored_at: float = -inf
    _against: int = 0
    """Reports in a row that break the test off: one alone may be a damaged frame."""

    def next_reports(self) -> Procedure[tuple[StatusReport, ...]]:
        """What came since the last call; none is no fault for a while."""
        sight: EngineView = yield Inspect()
        require_start(sight, self.restarts)
        reports: tuple[StatusReport, ...] = ()
        if sight.now - self._anchored_at > ANCHOR_EVERY_S:
            self._anchored_at = sight.now
            yield Ask(HEARTBEAT.query(), ASK_WAITS_S, attempts=1)
        if sight.device.is_streaming:
            heard: tuple[Received, ...] = yield Listen(LISTEN_S)
            reports = tuple(
                StatusReport(one.at, one.message)
                for one in heard
                if isinstance(one.message, Status) and one.role in (Role.STREAMED, Role.ANSWER)
            )
        else:
            yield Pause(ASK_EVERY_S)
        if not reports:
            outcome = yield Ask(STATUS.query(), ASK_WAITS_S, attempts=1)
            if isinstance(outcome, Answered):
                reports = tuple(StatusReport(outcome.at, one) for one in outcome.messages if isinstance(one, Status))
            sight = yield Inspect()
        self._check(reports, sight.now)
        return reports

    def _check(self, reports: tuple[StatusReport, ...], now: float) -> None:
        if self._heard_at is None or reports:
            self._heard_at = now
        if now - self._heard_at > SILENT_S:
            raise BreakOff(marked("The module does not answer."))
        for one in reports:
            is_other = one.status.active is not self.is_active
            is_against = is_other or (one.status.triggered and not self.may_trigger)
            self._against = self._against + 1 if is_against else 0
            if self._against < AGREEING:
                continue
            if not is_other:
                raise BreakOff(marked("The module reports that it has fired."))
            if self.is_active:
                raise BreakOff(marked("The module was locked."))
            raise BreakOff(marked("The module became ACTIVE."))


def require_start(sight: EngineView, restarts: int) -> None:
    """The module is still on the start that the test began on, and there."""
    if sight.device.restarts != restarts:
        raise BreakOff(marked("The module restarted."))
    if sight.device.presence is Presence.OFFLINE:
        raise BreakOff(marked("The module does not answer."))
    if sight.device.is_late:
        raise BreakOff(marked("Data arrives {seconds:.1f} s late."), seconds=LONGEST_LAG_S)


def require_locked() -> Procedure[int]:
    """Raises `BreakOff` unless the module reports now that it is locked and has not fired; its restarts so far."""
    yield from require_module()
    if not (yield from ask_status()):
        raise BreakOff(marked("No current status."))
    sight: EngineView = yield Inspect()
    active, triggered = (sight.device.proven(key, sight.now) for key in ("active", "triggered"))
    if active is None or triggered is None:
        raise BreakOff(marked("No current status."))
    if active.value:
        raise BreakOff(marked("The module is ACTIVE: lock it first."))
    if triggered.value:
        raise BreakOff(marked("The module reports that it has fired."))
    require_start(sight, sight.device.restarts)
    return sight.device.restarts


def read_setting(name: str) -> Procedure[float]:
    """A threshold as the module says it, twice alike. Raises `BreakOff` where it does not."""
    command = BY_NAME[name]
    back = yield from read_back(command)
    if back.raw is None or command.reply is None:
        raise BreakOff(NOT_READ, what=said(command.title))
    value: Value = command.reply.decode(back.raw)
    return float(value)
