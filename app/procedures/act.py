"""Performs one act at most once, logged before and after.

    conditions that need no question -> intent, durable -> who is there -> all conditions (`app.safety.interlocks`)
    -> the frame, once -> the module's reports -> outcome, logged

Nothing comes between the last answer to "who is there" and the frame but the pause of 50 ms that some modules need. For
locking see `app.procedures.lock`.

A permit allows at most one frame, in the conversation in which a person gave it: it is spent before the frame is sent,
and it expires while it waits. No act is repeated. The outcome is what the module reports afterwards.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from app.engine.conversation import Interrupted, StatusSample
from app.engine.procedure import (
    ASK_EVERY_S,
    Ask,
    Cancelled,
    EngineView,
    Inspect,
    Pause,
    Procedure,
    ask_report,
    ask_value,
)
from app.procedures.read import ACTIVE, ANSWERED_TWICE, TRIGGERED, Present, who_is_there
from app.safety.acts import REQUESTS, Act
from app.safety.interlocks import ASKS_NOTHING, FRESH_FOR_S, Interlock, InterlockInputs, Refusal, inputs_at, refusals
from app.safety.journal import Entry, Journal, Outcome, durable
from app.safety.permit import Permit
from app.text.i18n import tr
from app.text.messages import joined, message
from app.text.sentences import join_sentences
from app.text.user_error import UserError
from protocol.catalogue import BOOT_COUNT, BY_NAME, Request
from protocol.events import Answered, EndReason, Unanswered
from protocol.events import Outcome as Reply
from protocol.messages import Acknowledgement
from protocol.translatable import marked

_log = logging.getLogger(__name__)

# Reports in a row that must agree before a trigger is said not to have happened, and the pause in which a doubled first
# one passes.
READINGS = 2
READING_PAUSE_S = 0.15
# How long, before zeroing, reports are asked for.
WATCH_S = 2.0
# A module that acknowledged the activation may report it late: "still LOCKED" is said only after this time.
REPORTED_WITHIN_S = 1.5
# A module that still answers after this time did not shut down.
OFF_WITHIN_S = 2.5
# The module reports whole degrees.
ZEROED_WITHIN_DEG = 1
LOG_FAILED = marked("The audit log cannot be written.")
_NOT_SENT = marked("Nothing was sent.")

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


@dataclass(slots=True)
class Armed:
    """What is armed now; set by the window and read by the procedures."""

    act: Act | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Performed:
    """The result of an act. `refusals`: the conditions that are not met, so that nothing was sent."""

    act: Act
    outcome: Outcome
    refusals: tuple[Refusal, ...] = ()
    is_rehearsal: bool = False
    # The last report afterwards.
    status: StatusSample | None = None
    # Why it ended early.
    interrupted: Interrupted | None = None

    @property
    def sentence(self) -> str:
        """In the language in use now."""
        if self.is_rehearsal:
            return tr("Rehearsal: {frame} was not sent.", frame=REQUESTS[self.act].encode().hex(" ").upper())
        if self.outcome is Outcome.NOT_SENT:
            parts = [tr(_NOT_SENT), *(refusal.sentence for refusal in self.refusals)]
        else:
            parts = [tr(SENTENCES[self.act, self.outcome])]
            if self.act is Act.ZERO:
                parts.append(self._tilt_sentence)
        if self.interrupted is not None:
            parts.append(self.interrupted.sentence)
        return join_sentences(parts)

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


def rehearse(act: Act, permit: Permit) -> Performed:
    """Finish a rehearsal with the bytes that would have been sent. Raises ValueError for a real permit."""
    if not permit.is_rehearsal or permit.act is not act:
        raise ValueError("no rehearsal")
    permit.spend()
    return Performed(act=act, outcome=Outcome.NOT_SENT, is_rehearsal=True)


def perform(
    act: Act, journal: Journal, *, permit: Permit | None = None, armed: Armed | None = None
) -> Procedure[Performed]:
    """Perform one act of `REQUESTS` except LOCK (ValueError). An interruption or a cancellation after the frame has
    left leaves the outcome unknown, but for a shutdown, of which silence is the sign."""
    if act is Act.LOCK:
        raise ValueError("locking has a procedure of its own")
    if permit is not None and permit.is_rehearsal and permit.act is act:
        return rehearse(act, permit)
    request = REQUESTS[act]
    try:
        entry = yield from begin_act(act, request, journal, permit=permit, armed=armed)
    except (Interrupted, Cancelled) as error:
        interrupted = error if isinstance(error, Interrupted) else None
        return Performed(act=act, outcome=Outcome.NOT_SENT, interrupted=interrupted)
    if isinstance(entry, tuple):
        return Performed(act=act, outcome=Outcome.NOT_SENT, refusals=entry)
    reply: Reply | None = None
    observed = _Observed(Outcome.UNKNOWN)
    interrupted = None
    try:
        reply = yield Ask(request, is_deliberate=True)
        if _has_left(reply):
            observed = yield from _observe(act, _raw(reply))
        else:
            observed = _Observed(Outcome.NOT_SENT)  # LOCK overtook it
    except Cancelled:
        pass
    except Interrupted as error:
        interrupted = error
        if reply is None and error.is_unsent:
            observed = _Observed(Outcome.NOT_SENT)
        elif act is Act.SHUTDOWN and error.reason is EndReason.SILENT and _is_accepted(act, _raw(reply)):
            observed, interrupted = _Observed(Outcome.CONFIRMED), None
    raw, status = _raw(reply), observed.status
    _log.debug("%s: acknowledged with %s, %s", act.value, raw, observed.outcome.value)
    result: dict[str, object] = {"acknowledgement": None if raw is None else f"{raw:02X}"}
    if status is not None:
        result |= {"active": status.active, "triggered": status.triggered, "tilt_deg": status.tilt_deg}
    if interrupted is not None:
        result["why"] = interrupted.reason.value
    journal.settle(entry, observed.outcome, result)
    return Performed(act=act, outcome=observed.outcome, status=status, interrupted=interrupted)


def begin_act(
    act: Act,
    request: Request,
    journal: Journal,
    *,
    permit: Permit | None,
    armed: Armed | None,
    detail: Mapping[str, object] | None = None,
) -> Procedure[Entry | tuple[Refusal, ...]]:
    """Wait until the intent is durable, ask who is there, judge the conditions and spend the permit. Returns the entry:
    the frame may be sent now, and only now; else why not. `detail`: for the log; by default what is known."""
    view: EngineView = yield Inspect()
    inputs = replace(inputs_of(view, permit, armed), is_audit_ready=journal.is_ready)
    refused = refusals(act, inputs, only=ASKS_NOTHING)
    if refused:
        _log.debug("%s refused: %s", act.value, [refusal.condition.name for refusal in refused])
        return refused
    entry = journal.begin(act, request.encode(), _detail(view) if detail is None else detail)
    try:
        refused = yield from _open_conditions(act, entry, permit, armed)
    except (Interrupted, Cancelled) as error:
        journal.settle(entry, Outcome.NOT_SENT, {"why": type(error).__name__})
        raise
    if not refused and permit is not None and permit.spend():
        _log.debug("%s may be sent", act.value)
        return entry
    _log.debug("%s refused: %s", act.value, [refusal.condition.name for refusal in refused])
    journal.settle(entry, Outcome.NOT_SENT, {"why": [refusal.condition.name for refusal in refused]})
    return refused


def checked_inputs(
    present: Present, view: EngineView, *, permit: Permit | None = None, armed: Armed | None = None
) -> InterlockInputs:
    """What the conditions are judged by, just after it was asked who is there."""
    status = present.status
    contradiction = present.contradiction
    if contradiction is None and view.told.is_answered_twice(view.now):
        contradiction = ANSWERED_TWICE
    age_s = None if status is None else view.now - present.asked_at
    return replace(
        inputs_of(view, permit, armed),
        status_age_s=age_s,
        is_status_fresh=age_s is not None and age_s <= FRESH_FOR_S,
        active=None if status is None else status.active,
        triggered=None if status is None else status.triggered,
        tilt_deg=None if status is None else status.tilt_deg,
        contradiction=contradiction,
    )


def inputs_of(view: EngineView, permit: Permit | None, armed: Armed | None) -> InterlockInputs:
    """What is known without asking the module anything."""
    return replace(
        inputs_at(view.conversation, view.now),
        permit=permit,
        overtaken_at=view.overtaken_at,
        armed=None if armed is None else armed.act,
        sets_rate=view.sets_rate,
    )


def _open_conditions(
    act: Act, entry: Entry, permit: Permit | None, armed: Armed | None
) -> Procedure[tuple[Refusal, ...]]:
    try:
        yield from durable(entry)
    except Interrupted:
        raise
    except UserError as error:
        why = joined((message(LOG_FAILED), error.message), " ")
        return (Refusal(Interlock.INTENT_DURABLE, why),)
    if act is Act.ACTIVATE:
        yield from ask_value(BY_NAME["attitude_threshold"])
    if act is Act.ZERO:
        yield from _watch(WATCH_S)  # to judge whether it lies still
    present = yield from who_is_there()
    view: EngineView = yield Inspect()
    return refusals(act, checked_inputs(present, view, permit=permit, armed=armed))


def _watch(seconds: float) -> Procedure[None]:
    view: EngineView = yield Inspect()
    now, ends_at = view.now, view.now + seconds
    while now < ends_at:
        yield from ask_report()
        now = yield Pause(ASK_EVERY_S)


def _detail(view: EngineView) -> dict[str, object]:
    """What was known at the decision, for the log."""
    keys = ("tilt_deg", "acceleration_g", "active", "triggered", "boot_count", "attitude_threshold_deg")
    return {key: view.conversation.fresh(key, view.now) for key in keys}


# What the module reports afterwards


class _Observed(NamedTuple):
    outcome: Outcome
    status: StatusSample | None = None


def _observe(act: Act, raw: int | None) -> Procedure[_Observed]:
    """`raw`: the byte of the acknowledgement."""
    if act is Act.SHUTDOWN:
        yield Pause(OFF_WITHIN_S)  # its silence ends the conversation, and this
        return _Observed(Outcome.REFUSED)
    if act is Act.ACTIVATE:
        observed = yield from _observe_activation(raw)
    elif act is Act.DEPLOY:
        observed = yield from _observe_deploy(raw)
    else:
        status = yield from ask_report(is_fenced=raw is None)
        outcome = Outcome.CONFIRMED if _is_accepted(act, raw) else Outcome.REFUSED
        observed = _Observed(Outcome.UNKNOWN if raw is None else outcome, status)
    yield from ask_value(BOOT_COUNT)  # the reports were the same module's, or this ends it
    return observed


def _observe_activation(raw: int | None) -> Procedure[_Observed]:
    view: EngineView = yield Inspect()
    ends_at = view.now + REPORTED_WITHIN_S
    while True:
        # Without an answer to the act an old report could still come.
        active = yield from ask_value(ACTIVE, is_fenced=raw is None)
        status = yield from ask_report()
        if active is None or status is None or active.value != status.active:
            outcome = Outcome.UNKNOWN
        elif status.active:
            outcome = Outcome.CONFIRMED
        else:
            # Unanswered, it may still be carried out.
            outcome = Outcome.UNKNOWN if raw is None else Outcome.REFUSED
        view = yield Inspect()
        if outcome is Outcome.CONFIRMED or not _is_accepted(Act.ACTIVATE, raw) or view.now >= ends_at:
            return _Observed(outcome, status)
        yield Pause(ASK_EVERY_S)


def _observe_deploy(raw: int | None) -> Procedure[_Observed]:
    """It had not fired before (a condition), so a reported trigger is this one. "Not fired" needs every answer."""
    triggered = yield from ask_value(TRIGGERED)
    reports: list[StatusSample] = []
    for number in range(READINGS):
        if number:
            yield Pause(READING_PAUSE_S)
        report = yield from ask_report(is_fenced=raw is None and number == 0)
        if report is not None:
            reports.append(report)
    last = reports[-1] if reports else None
    has_fired = triggered is not None and triggered.value is True
    if has_fired or _is_accepted(Act.DEPLOY, raw) or any(report.triggered for report in reports):
        return _Observed(Outcome.CONFIRMED, last)
    if raw == 0x00 and triggered is not None and len(reports) == READINGS:
        return _Observed(Outcome.REFUSED, last)
    return _Observed(Outcome.UNKNOWN, last)


def _is_accepted(act: Act, raw: int | None) -> bool:
    return raw is not None and Acknowledgement(REQUESTS[act], raw).is_accepted


def _raw(reply: Reply | None) -> int | None:
    answer = reply.messages[0] if isinstance(reply, Answered) else None
    return answer.raw if isinstance(answer, Acknowledgement) else None


def _has_left(reply: Reply) -> bool:
    return not isinstance(reply, Unanswered) or reply.attempts > 0
