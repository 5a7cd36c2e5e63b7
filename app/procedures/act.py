"""Performs one act at most once, logged before and after.

    ask who is there -> conditions (`app.safety.interlocks`) -> intent, durable -> ask who is there -> conditions again
    -> the frame, once -> the module's reports -> outcome, logged

For locking see `app.procedures.lock`.

A permit allows at most one frame: it is spent before the frame is sent, and it expires while it waits. No act is
repeated. The outcome is what the module reports afterwards.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from app.engine.device import StatusSample
from app.engine.procedure import (
    ASK_EVERY_S,
    Ask,
    Cancelled,
    EngineView,
    Inspect,
    Pause,
    PortLost,
    Procedure,
    TwoModules,
    ask_report,
    ask_value,
    is_alive,
    pause_asking,
)
from app.engine.transport import PortError
from app.procedures.settings_reading import Seen, look
from app.procedures.who_is_there import ACTIVE, ANSWERED_TWICE, TRIGGERED
from app.safety.acts import REQUESTS, Act
from app.safety.interlocks import Interlock, Refusal, interlock_inputs, refusals
from app.safety.journal import Entry, Journal, Outcome, durable
from app.safety.permit import Permit
from app.text.i18n import tr
from app.text.messages import joined, message
from app.text.sentences import join_sentences
from app.text.user_error import UserError
from protocol.catalogue import BOOT_COUNT, BY_NAME, Command, Request
from protocol.events import Answered, Unanswered
from protocol.events import Outcome as Reply
from protocol.lag import QUICK_S
from protocol.messages import Acknowledgement
from protocol.translatable import marked

AFTER_WAITS_S = (0.3, 0.3, 1.0)
ALIVE_AGAIN_S = 0.5
READING_PAUSE_S = 0.15
READINGS = 2
"""Reports in a row that must agree before a trigger is said not to have happened."""

SENTENCES: Mapping[tuple[Act, Outcome], str] = {
    (Act.ACTIVATE, Outcome.CONFIRMED): marked("The module reports ACTIVE."),
    (Act.ACTIVATE, Outcome.REFUSED): marked("The module still reports LOCKED."),
    (Act.ACTIVATE, Outcome.UNKNOWN): marked("Sent, not confirmed: treat the module as ACTIVE."),
    (Act.ZERO, Outcome.CONFIRMED): marked("Acknowledged."),
    (Act.ZERO, Outcome.REFUSED): marked("The module refused."),
    (Act.ZERO, Outcome.UNKNOWN): marked("Sent, not confirmed."),
    (Act.SHUTDOWN, Outcome.CONFIRMED): marked("Acknowledged; the module is silent."),
    (Act.SHUTDOWN, Outcome.REFUSED): marked("The module still answers: not switched off."),
    (Act.SHUTDOWN, Outcome.UNKNOWN): marked("Not confirmed that it is off: check it."),
    (Act.FORBID_DEPLOY, Outcome.CONFIRMED): marked("Acknowledged; for how long is unknown."),
    (Act.FORBID_DEPLOY, Outcome.REFUSED): marked("The module refused."),
    (Act.FORBID_DEPLOY, Outcome.UNKNOWN): marked("Sent, not confirmed."),
    (Act.DEPLOY, Outcome.CONFIRMED): marked("The module reports that it has fired."),
    (Act.DEPLOY, Outcome.REFUSED): marked("The module refused and reports no trigger."),
    (Act.DEPLOY, Outcome.UNKNOWN): marked("Sent, not confirmed: treat it as fired."),
}
ZEROED_WITHIN_DEG = 1
"""The module reports whole degrees."""
WATCH_S = 2.0
"""How long, before zeroing, reports are asked for."""
REPORTED_WITHIN_S = 1.5
"""A module that acknowledged the activation may report it late: "still LOCKED" is said only after this time."""
SECOND_MODULE_S = 1.0
"""From the first answer on: a second module on the line has the vendor's second for its answers, too."""
LOG_FAILED = marked("The audit log cannot be written.")
_NOT_SENT = marked("Nothing was sent.")


@dataclass(frozen=True, slots=True, kw_only=True)
class Performed:
    """The result of an act. `refusals`: the conditions that are not met, so that nothing was sent."""

    act: Act
    outcome: Outcome
    refusals: tuple[Refusal, ...] = ()
    is_rehearsal: bool = False
    status: StatusSample | None = None
    """The last report afterwards."""

    @property
    def sentence(self) -> str:
        """In the language in use now."""
        if self.is_rehearsal:
            return tr("Rehearsal: {frame} was not sent.", frame=REQUESTS[self.act].encode().hex(" ").upper())
        if self.outcome is not Outcome.NOT_SENT:
            words = tr(SENTENCES[self.act, self.outcome])
            return join_sentences((words, self._tilt_sentence)) if self.act is Act.ZERO else words
        return join_sentences((tr(_NOT_SENT), *(refusal.sentence for refusal in self.refusals)))

    @property
    def is_level(self) -> bool:
        """Whether the module reports a tilt near 0 afterwards, as it should after zeroing."""
        return self.status is not None and self.status.tilt_deg <= ZEROED_WITHIN_DEG

    @property
    def _tilt_sentence(self) -> str:
        if self.status is None:
            return tr("Could not read the tilt: check it.")
        if self.is_level:
            return tr("Tilt now {tilt:.0f}°.", tilt=self.status.tilt_deg)
        return tr("Tilt now {tilt:.0f}°, not 0°: check the mounting.", tilt=self.status.tilt_deg)


@dataclass(slots=True)
class Armed:
    """What is armed now; set by the window and read by the procedures."""

    act: Act | None = None


def rehearse(act: Act, permit: Permit) -> Performed:
    """Finish a rehearsal with the bytes that would have been sent. Raises ValueError for a real permit."""
    if not permit.is_rehearsal or permit.act is not act:
        raise ValueError("no rehearsal")
    permit.spend()
    return Performed(act=act, outcome=Outcome.NOT_SENT, is_rehearsal=True)


class _Observed(NamedTuple):
    is_acknowledged: bool
    raw: int | None
    reports: tuple[StatusSample, ...] = ()
    is_alive: bool | None = None
    has_fired: bool | None = None
    """For deploying: the answer to "triggered?"."""
    is_active: bool | None = None
    """For activating: the answer to "active?"."""


def perform(
    act: Act, journal: Journal, *, permit: Permit | None = None, armed: Armed | None = None
) -> Procedure[Performed]:
    """Perform one act of `REQUESTS` except LOCK, for which see `app.procedures.lock`. If the port is lost or the act is
    cancelled after the frame may have been sent, the outcome is unknown."""
    if act is Act.LOCK:
        raise ValueError("locking has a procedure of its own")
    if permit is not None and permit.is_rehearsal and permit.act is act:
        return rehearse(act, permit)
    request = REQUESTS[act]
    entry: Entry | tuple[Refusal, ...]
    try:
        entry = yield from begin_act(act, request, journal, permit=permit, armed=armed)
    except TwoModules as error:
        entry = (Refusal(Interlock.AGREES, error.message),)
    if isinstance(entry, tuple):
        return Performed(act=act, outcome=Outcome.NOT_SENT, refusals=entry)
    try:
        answer = yield Ask(request, is_deliberate=True)
        if isinstance(answer, Unanswered):  # it never left
            journal.settle(entry, Outcome.NOT_SENT, {})
            return Performed(act=act, outcome=Outcome.NOT_SENT)
        before: EngineView = yield Inspect()
        after = yield from _observe_after(act, answer)
        is_broken = _is_quick(before) and (yield Inspect()).device.breaks != before.device.breaks
        if after.raw is not None and is_broken:  # it may be another module that reports
            is_alive = None if after.is_alive else after.is_alive
            after = after._replace(reports=(), has_fired=None, is_alive=is_alive)
    except (Cancelled, PortLost, PortError) as error:
        journal.settle(entry, Outcome.UNKNOWN, {"why": type(error).__name__})
        return Performed(act=act, outcome=Outcome.UNKNOWN)
    journal.settle(entry, _outcome(act, after), _result(after))
    return Performed(act=act, outcome=_outcome(act, after), status=after.reports[-1] if after.reports else None)


def begin_act(
    act: Act, request: Request, journal: Journal, *, permit: Permit | None, armed: Armed | None,
    detail: Mapping[str, object] | None = None, begin: EngineView | None = None,
) -> Procedure[Entry | tuple[Refusal, ...]]:  # fmt: skip
    """Judge the conditions, wait until the intent is durable, judge them again and spend the permit. The entry: the
    frame may be sent now, and only now; else why not. `detail`: for the log; else what is known. `begin`: of the module
    that it was decided for; by default the one that answers now."""
    begin = begin or (yield Inspect())
    yield from _prepare(act)
    seen = yield from look(begin)
    view: EngineView = yield Inspect()
    refused = _conditions_open(act, view, journal, permit=permit, armed=armed, seen=seen)
    if refused:
        return refused
    entry = journal.begin(act, request.encode(), _detail(view) if detail is None else detail)
    try:
        try:
            if (yield from durable(entry)):  # the disk was slow
                yield from _prepare(act)
            seen = yield from look(begin)
            yield Pause(0.0)  # lets the session read the clock and the line
            refused = _conditions_open(act, (yield Inspect()), journal, permit=permit, armed=armed, seen=seen)
            if not refused and permit is not None and permit.spend():
                return entry
        except UserError as error:
            why = joined((message(LOG_FAILED), error.message), " ")
            refused = (Refusal(Interlock.INTENT_DURABLE, why),)
    except (Cancelled, PortLost, PortError) as error:
        journal.settle(entry, Outcome.NOT_SENT, {"why": type(error).__name__})
        raise
    journal.settle(entry, Outcome.NOT_SENT, {"why": [refusal.condition.name for refusal in refused]})
    return refused


def _prepare(act: Act) -> Procedure[None]:
    """Learn what takes time."""
    view: EngineView = yield Inspect()
    since = view.now if view.told is None or view.told.since is None else view.told.since
    early_s = since + SECOND_MODULE_S - view.now
    if early_s > 0:
        yield Ask(BOOT_COUNT.query())
        yield from pause_asking(early_s)
    if act is Act.ZERO:
        yield from pause_asking(WATCH_S)  # to judge whether it lies still
    yield from _ask_threshold(act)


def _is_quick(view: EngineView) -> bool:
    """Whether the line is: else an answer takes as long as a silence that breaks the conversation."""
    return view.device.lag_s is None or view.device.lag_s < QUICK_S


def _ask_threshold(act: Act) -> Procedure[None]:
    """For activating, where it is not known."""
    view: EngineView = yield Inspect()
    if act is Act.ACTIVATE and view.device.fresh("attitude_threshold_deg", view.now) is None:
        yield Ask(BY_NAME["attitude_threshold"].query())


def _conditions_open(
    act: Act, view: EngineView, journal: Journal, *, permit: Permit | None, armed: Armed | None, seen: Seen
) -> tuple[Refusal, ...]:
    """The conditions of `act` that are not met at the time of `view`; none if it may be sent."""
    inputs = replace(
        interlock_inputs(view.device, view.now, must_be_proven=True),
        is_identity_settled=view.is_settled and seen.is_same,
        contradiction=seen.present.contradiction or (ANSWERED_TWICE if view.is_answered_twice else None),
        permit=permit,
        overtaken_at=view.overtaken_at,
        opened_at=view.opened_at,
        armed=armed.act if armed is not None else None,
        is_audit_ready=journal.is_ready,
        sets_rate=view.sets_rate,
    )
    return refusals(act, inputs)


def _detail(view: EngineView) -> dict[str, object]:
    """What was known at the decision, for the log."""
    keys = ("tilt_deg", "acceleration_g", "active", "triggered", "boot_count", "attitude_threshold_deg")
    return {key: view.device.fresh(key, view.now) for key in keys}


def _observe_after(act: Act, outcome: Reply) -> Procedure[_Observed]:
    """Read the module's state after the act; `outcome` is the reply to the act."""
    message = outcome.messages[0] if isinstance(outcome, Answered) else None
    raw = message.raw if isinstance(message, Acknowledgement) else None
    is_acknowledged = isinstance(message, Acknowledgement) and message.is_accepted
    if act is Act.SHUTDOWN:
        is_alive = yield from _still_answers()
        return _Observed(is_acknowledged, raw, is_alive=is_alive)
    has_fired = (yield from _said(TRIGGERED)) if act is Act.DEPLOY else None
    # After an answer to the act all reports are newer. Without one an old report could still come.
    reports = yield from _reports(is_fenced=message is None, apart_s=READING_PAUSE_S if act is Act.DEPLOY else 0.0)
    if act is Act.ACTIVATE and is_acknowledged:
        view: EngineView = yield Inspect()
        ends_at = view.now + REPORTED_WITHIN_S
        while reports and not all(report.active for report in reports) and view.now < ends_at:
            yield Pause(ASK_EVERY_S)
            reports = yield from _reports(is_fenced=False)
            view = yield Inspect()
    is_active = (yield from _said(ACTIVE)) if act is Act.ACTIVATE else None
    return _Observed(is_acknowledged, raw, reports, has_fired=has_fired, is_active=is_active)


def _still_answers() -> Procedure[bool]:
    """Ask twice, with a pause: a doubled reply to an earlier heartbeat must not count."""
    for pause_s in (ALIVE_AGAIN_S, 0.0):
        if not (yield from is_alive(AFTER_WAITS_S)):
            return False
        yield Pause(pause_s)
    return True


def _said(command: Command) -> Procedure[bool | None]:
    """Ask "active?" or "triggered?", which a doubled status cannot answer. None: no answer."""
    reading = yield from ask_value(command, AFTER_WAITS_S)
    return bool(reading.value) if reading is not None else None


def _reports(*, is_fenced: bool, apart_s: float = 0.0) -> Procedure[tuple[StatusSample, ...]]:
    """Ask for `READINGS` reports. `apart_s`: the pause in which a doubled first report passes."""
    reports: list[StatusSample] = []
    for number in range(READINGS):
        if number and apart_s:
            yield Pause(apart_s)
        seen = yield from ask_report(AFTER_WAITS_S, is_fenced=is_fenced and number == 0)
        if seen is not None:
            reports.append(seen)
    return tuple(reports)


def _outcome(act: Act, after: _Observed) -> Outcome:
    match act:
        case Act.ACTIVATE:
            return _activation_outcome(after)
        case Act.SHUTDOWN:
            if after.is_alive:
                return Outcome.REFUSED
            return Outcome.CONFIRMED if after.is_acknowledged and after.is_alive is False else Outcome.UNKNOWN
        case Act.DEPLOY:
            return _deploy_outcome(after)
        case _:
            if after.is_acknowledged:
                return Outcome.CONFIRMED
            return Outcome.UNKNOWN if after.raw is None else Outcome.REFUSED


def _activation_outcome(after: _Observed) -> Outcome:
    states = {report.active for report in after.reports}
    if len(after.reports) < READINGS or len(states) != 1:
        return Outcome.UNKNOWN
    if after.is_active not in states:
        return Outcome.UNKNOWN
    if states == {True}:
        return Outcome.CONFIRMED
    # Without an answer to the act the reports may be older than the act.
    return Outcome.UNKNOWN if after.raw is None else Outcome.REFUSED


def _deploy_outcome(after: _Observed) -> Outcome:
    """It had not fired before (a condition), so a reported trigger is this one. "Not fired" needs every answer."""
    if after.is_acknowledged or after.has_fired or any(report.triggered for report in after.reports):
        return Outcome.CONFIRMED
    if after.raw == 0x00 and after.has_fired is False and len(after.reports) == READINGS:
        return Outcome.REFUSED
    return Outcome.UNKNOWN


def _result(after: _Observed) -> dict[str, object]:
    last = after.reports[-1] if after.reports else None
    return {
        "acknowledgement": None if after.raw is None else f"{after.raw:02X}",
        "is_alive": after.is_alive,
        "active": None if last is None else last.active,
        "triggered": None if last is None else last.triggered,
        "tilt_deg": None if last is None else last.tilt_deg,
    }
