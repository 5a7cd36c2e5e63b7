"""Performs one act at most once, logged before and after.

    conditions that need no question -> intent, durable -> who is there -> all conditions (`app.safety.permit`)
    -> the frame, once -> the module's reports -> outcome, logged

Nothing comes between the last answer to "who is there" and the frame but the pause of 50 ms that some modules need. For
locking see `app.procedures.lock`.

A permit is spent before its frame is sent, and expires while it waits. No act is repeated. The outcome is what the
module reports afterwards.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass, replace

from app.engine.conversation import FRESH_FOR_S, Interrupted, StatusSample
from app.engine.procedure import Ask, Cancelled, EngineView, Inspect, Pause, Procedure, answer_in, ask_report, ask_value
from app.procedures.read import ACTIVE, ANSWERED_TWICE, TRIGGERED, Present, who_is_there
from app.safety.journal import REQUESTS, Act, Entry, Journal, Outcome, durable
from app.safety.permit import ASKS_NOTHING, Interlock, InterlockInputs, Permit, Refusal, inputs_at, refusals
from app.text.i18n import tr
from app.text.messages import UserError, join_sentences, joined, message
from protocol.catalogue import BOOT_COUNT, BY_NAME, Request
from protocol.events import EndReason
from protocol.messages import Acknowledgement
from protocol.translatable import marked

_log = logging.getLogger(__name__)

# Where the module is asked again and again.
ASK_EVERY_S = 0.05
# Between the two reports after a deploy: in it a doubled first one passes.
READING_PAUSE_S = 0.15
# How long, before zeroing, reports are asked for.
WATCH_S = 2.0
# A module that acknowledged the activation may report it late: "still LOCKED" is said only after this time.
REPORTED_WITHIN_S = 1.5
# A module that still answers after this time did not shut down.
OFF_WITHIN_S = 2.5
# The module reports whole degrees.
ZEROED_WITHIN_DEG = 1
# Of what is known at the decision, for the log.
_LOGGED = ("tilt_deg", "acceleration_g", "active", "triggered", "boot_count", "attitude_threshold_deg")

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
    """It names the act that is armed now; set by the window and read by the procedures."""

    act: Act | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Performed:
    """The result of an act. `refusals`: the conditions that are not met, so that nothing was sent."""

    act: Act
    outcome: Outcome
    refusals: tuple[Refusal, ...] = ()
    status: StatusSample | None = None  # the last report afterwards
    interrupted: Interrupted | None = None  # why it ended early

    @property
    def is_level(self) -> bool:
        """Whether the module reports a tilt near 0 afterwards, as it should after zeroing."""
        return self.status is not None and self.status.tilt_deg <= ZEROED_WITHIN_DEG

    @property
    def sentence(self) -> str:
        """The sentence in the language in use now."""
        if self.outcome is Outcome.NOT_SENT:
            parts = [tr("Nothing was sent."), *(refusal.sentence for refusal in self.refusals)]
        else:
            parts = [tr(SENTENCES[self.act, self.outcome])]
            if self.act is Act.ZERO and self.status is None:
                parts.append(tr("Could not read the tilt: check it."))
            elif self.act is Act.ZERO and self.status is not None:
                off_level = marked("Tilt now {tilt:.0f}°, not 0°: check the mounting.")
                text = marked("Tilt now {tilt:.0f}°.") if self.is_level else off_level
                parts.append(tr(text, tilt=self.status.tilt_deg))
        if self.interrupted is not None:
            parts.append(self.interrupted.sentence)
        return join_sentences(parts)


def perform(
    act: Act, journal: Journal, *, permit: Permit | None = None, armed: Armed | None = None
) -> Procedure[Performed]:
    """Perform one act of `REQUESTS`; locking has a procedure of its own. An interruption or a cancellation after the
    frame has left leaves the outcome unknown, but for a shutdown, of which silence is the sign."""
    request = REQUESTS[act]
    try:
        entry = yield from begin_act(act, request, journal, permit=permit, armed=armed)
    except (Interrupted, Cancelled) as error:
        interrupted = error if isinstance(error, Interrupted) else None
        return Performed(act=act, outcome=Outcome.NOT_SENT, interrupted=interrupted)
    if isinstance(entry, tuple):
        return Performed(act=act, outcome=Outcome.NOT_SENT, refusals=entry)
    outcome, reply, interrupted = Outcome.UNKNOWN, None, None
    answer: Acknowledgement | None = None
    status: StatusSample | None = None
    try:
        reply = yield Ask(request, is_deliberate=True)
        answer = answer_in(reply, Acknowledgement)
        if not reply.attempts:
            outcome = Outcome.NOT_SENT  # LOCK overtook it, or this program stood still
        else:
            outcome, status = yield from _observe(act, answer)
            yield from ask_value(BOOT_COUNT)  # the reports were the same module's, or this ends it
    except Cancelled:
        outcome = Outcome.UNKNOWN
    except Interrupted as error:
        interrupted, status = error, None
        outcome = Outcome.NOT_SENT if reply is None and error.is_unsent else Outcome.UNKNOWN
        if act is Act.SHUTDOWN and error.reason is EndReason.SILENT and answer is not None and answer.is_accepted:
            outcome, interrupted = Outcome.CONFIRMED, None
    _log.debug("%s: acknowledged with %s, %s", act.value, answer, outcome.value)
    result: dict[str, object] = {"acknowledgement": None if answer is None else f"{answer.raw:02X}"}
    if status is not None:
        result |= {"active": status.active, "triggered": status.triggered, "tilt_deg": status.tilt_deg}
    if interrupted is not None:
        result["why"] = interrupted.reason.name
    journal.settle(entry, outcome, result)
    return Performed(act=act, outcome=outcome, status=status, interrupted=interrupted)


def begin_act(
    act: Act,
    request: Request,
    journal: Journal,
    *,
    permit: Permit | None,
    armed: Armed | None,
    detail: Mapping[str, object] | None = None,
) -> Procedure[Entry | tuple[Refusal, ...]]:
    """Do everything before the frame. Returns the entry: it may be sent now, and only now; else why not. `detail`: for
    the log; by default what is known."""
    view: EngineView = yield Inspect()
    inputs = replace(inputs_of(view, permit=permit, armed=armed), is_audit_ready=journal.is_ready)
    refused = refusals(act, inputs, only=ASKS_NOTHING)
    if refused:
        _log.debug("%s refused: %s", act.value, [refusal.condition.name for refusal in refused])
        return refused
    known = {key: view.conversation.fresh(key, view.now) for key in _LOGGED}
    entry = journal.begin(act, request.encode(), known if detail is None else detail)
    try:
        yield from durable(entry)
        if act is Act.ACTIVATE:  # to judge whether it would fire at once
            yield from ask_value(BY_NAME["attitude_threshold"])
        if act is Act.ZERO:  # to judge whether it lies still
            view = yield Inspect()
            now, ends_at = view.now, view.now + WATCH_S
            while now < ends_at:
                yield from ask_report()
                now = yield Pause(ASK_EVERY_S)
        present = yield from who_is_there()
        view = yield Inspect()
        inputs = inputs_of(view, permit=permit, armed=armed, present=present)
        # Two modules that tell the same contradict nothing, and yet both would obey.
        if inputs.contradiction is None and view.lasting.is_answered_twice(view.now):
            inputs = replace(inputs, contradiction=ANSWERED_TWICE)
        refused = refusals(act, inputs)
    except (Interrupted, Cancelled) as error:
        journal.settle(entry, Outcome.NOT_SENT, {"why": type(error).__name__})
        raise
    except UserError as error:
        why = joined((message(marked("The audit log cannot be written.")), error.message), " ")
        refused = (Refusal(Interlock.INTENT_DURABLE, why),)
    if refused or permit is None:
        whys = [refusal.condition.name for refusal in refused]
        _log.debug("%s refused: %s", act.value, whys)
        journal.settle(entry, Outcome.NOT_SENT, {"why": whys})
        return refused
    # Spent before the frame leaves: whatever comes of it, this permit allows no second one.
    permit.is_spent = True
    _log.debug("%s may be sent", act.value)
    return entry


def inputs_of(
    view: EngineView, *, permit: Permit | None = None, armed: Armed | None = None, present: Present | None = None
) -> InterlockInputs:
    """Return what the conditions are judged by. `present`: what was answered just now; else what is known without
    asking the module anything."""
    inputs = replace(
        inputs_at(view.conversation, view.now),
        permit=permit,
        overtaken_at=view.overtaken_at,
        armed=None if armed is None else armed.act,
        sets_rate=view.sets_rate,
    )
    if present is None:
        return inputs
    status = present.status
    return replace(
        inputs,
        is_status_fresh=status is not None and view.now - present.asked_at <= FRESH_FOR_S["active"],
        active=None if status is None else status.active,
        triggered=None if status is None else status.triggered,
        tilt_deg=None if status is None else status.tilt_deg,
        contradiction=present.contradiction,
    )


def _observe(act: Act, answer: Acknowledgement | None) -> Procedure[tuple[Outcome, StatusSample | None]]:
    """Ask what the module reports after the act."""
    # Without an answer to it an old report could still come, so the first question is fenced; and what is not reported
    # may still be carried out.
    is_accepted = answer is not None and answer.is_accepted
    if act is Act.SHUTDOWN:
        yield Pause(OFF_WITHIN_S)  # its silence ends the conversation, and this
        return Outcome.REFUSED, None
    if act is Act.DEPLOY:
        # It had not fired before (a condition), so a reported trigger is this one. "Not fired" needs every answer.
        triggered = yield from ask_value(TRIGGERED)
        first = yield from ask_report(is_fenced=answer is None)
        yield Pause(READING_PAUSE_S)
        second = yield from ask_report()
        reports_fired = any(report is not None and report.triggered for report in (first, second))
        outcome = Outcome.UNKNOWN
        if triggered is True or reports_fired or is_accepted:
            outcome = Outcome.CONFIRMED
        elif answer is not None and None not in (triggered, first, second):
            outcome = Outcome.REFUSED
        return outcome, second or first
    if act is not Act.ACTIVATE:
        status = yield from ask_report(is_fenced=answer is None)
        if answer is None:
            return Outcome.UNKNOWN, status
        return Outcome.CONFIRMED if is_accepted else Outcome.REFUSED, status
    view: EngineView = yield Inspect()
    ends_at = view.now + REPORTED_WITHIN_S
    while True:
        active = yield from ask_value(ACTIVE, is_fenced=answer is None)
        status = yield from ask_report()
        outcome = Outcome.UNKNOWN
        if active is not None and status is not None and active == status.active:
            if status.active:
                return Outcome.CONFIRMED, status
            outcome = Outcome.UNKNOWN if answer is None else Outcome.REFUSED
        view = yield Inspect()
        if not is_accepted or view.now >= ends_at:
            return outcome, status
        yield Pause(ASK_EVERY_S)
