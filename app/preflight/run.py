"""Pre-flight check as a procedure: collects evidence with queries only, judges nothing; and from READY to GO.

    20 heartbeats -> settings, who is there -> trigger records -> the two trigger flags, only when asked
                  -> cell, charge, light -> two seconds of status -> settings, who is there, once more

An interruption makes the check void, and that is the whole treatment of restarts, silences and exchanged modules.
Nothing that the check sends activates, locks, fires, zeroes, shuts down or changes the rate.
"""

import logging
from dataclasses import replace

from app.engine.conversation import How, Interrupted
from app.engine.procedure import Ask, EngineView, Inspect, Pause, Procedure, Report, ask_report, ask_value
from app.preflight.evidence import HEARTBEATS, STILL_S, UNREAD, Evidence, TriggerFlag, read_state, void_of_end
from app.preflight.verdict import Assessment, void_reason
from app.procedures.act import Performed, perform
from app.procedures.history import read_history
from app.procedures.write import SettingChange, WriteContext, WriteFault, await_flags_known, set_each, why_not_verified
from app.safety.journal import Act, Journal, Outcome
from app.safety.permit import Interlock, Permit, Refusal
from app.text.messages import message
from protocol.catalogue import BY_NAME, HEARTBEAT
from protocol.events import Answered
from protocol.stale_replies import TRIGGER_FLAGS
from protocol.translatable import marked

_log = logging.getLogger(__name__)

STEPS = 7
REPORT_EVERY_S = 0.05
# Without a question; a stream that is faster than half the reports that are asked for is seen in it.
QUIET_S = 0.3
# Of asking for cell voltage, charging and light.
VALUE_ROUNDS = 3
SLOW = tuple(BY_NAME[name] for name in ("cell_voltage", "charging", "light"))
# A module that restarts when it is activated has said so by then.
SETTLE_S = 0.6


def run_preflight(evidence: Evidence, *, is_enabling: bool = False, journal: Journal | None = None) -> Procedure[None]:
    """Fill `evidence`; with `is_enabling` enable both automatic triggers, if the module is locked. Raises `Interrupted`
    or `Cancelled`, which whoever runs it notes in the evidence: it may not even have begun."""
    begin: EngineView = yield Inspect()
    evidence.conversation = begin.conversation.number
    evidence.baud_rate = begin.baud_rate
    _log.debug("checking in conversation %d", evidence.conversation)

    yield Report(0, STEPS, marked("Link"))
    for _ in range(HEARTBEATS):
        evidence.heartbeats_sent += 1
        outcome = yield Ask(HEARTBEAT.query())
        if not isinstance(outcome, Answered) or outcome.attempts > 1:
            evidence.heartbeats_lost += 1
        elif outcome.round_trip_s is not None:
            evidence.round_trips_s.append(outcome.round_trip_s)
    view: EngineView = yield Inspect()
    evidence.rejected_bytes = view.rejected_bytes - begin.rejected_bytes

    # What decides is asked twice, here and at the end, because the 8-bit checksum lets some damaged frames pass: two
    # answers that differ end the conversation.
    yield Report(1, STEPS, marked("Settings"))
    state = yield from read_state()
    evidence.note_state(state)

    yield Report(2, STEPS, marked("Trigger records"))
    evidence.history = yield from read_history()

    yield Report(3, STEPS, marked("Triggers"))
    evidence.flags = {command.key: TriggerFlag() for command in TRIGGER_FLAGS}
    if is_enabling:
        # Each is sent once, and never to an active module.
        changes = [SettingChange(command, True) for command in TRIGGER_FLAGS]
        report = yield from set_each(changes, WriteContext(journal=journal or Journal()))
        for written in report.results:
            why = why_not_verified(written, report)
            if why is not None:
                evidence.flags[written.command.key] = TriggerFlag(why=why)

    # In turn, so that a charger that is plugged in meanwhile is seen in the round in which it changed the voltage.
    yield Report(4, STEPS, marked("Cell voltage"))
    for command in SLOW * VALUE_ROUNDS:
        value = yield from ask_value(command)
        if value is None:
            evidence.unanswered.add(command.key)
        else:
            evidence.series.setdefault(command.key, []).append(value)

    yield Report(5, STEPS, marked("Tilt and acceleration"))
    has_stream = yield from _has_stream()
    view = yield Inspect()
    now, streamed_before = view.now, view.conversation.streamed
    ends_at = now + STILL_S
    while now < ends_at:
        status = yield from ask_report()
        if status is not None:
            evidence.status = status
            evidence.reports.append(status)
        now = yield Pause(REPORT_EVERY_S)
    view = yield Inspect()
    # Half as many reports again as were asked for come from a second module.
    if not has_stream and view.conversation.streamed - streamed_before > len(evidence.reports) / 2:
        evidence.is_answered_twice = True

    # On some lines an answer comes twice (`protocol.stale_replies`): only by now a copy would have told.
    yield from await_flags_known(Report(5, STEPS, ""))
    yield Report(6, STEPS, marked("Settings"))
    state = yield from read_state()
    evidence.note_state(state)

    end: EngineView = yield Inspect()
    evidence.is_answered_twice |= end.lasting.twice_at >= begin.now
    for key in evidence.flags:
        # What the module acknowledged in this conversation, and was not asked to change since without an answer.
        known = end.conversation.known(key, end.now)
        if known is not None and not known.is_stale and known.how is How.ACKNOWLEDGED:
            evidence.flags[key] = TriggerFlag(known.value is True)
        elif end.flags.has_repeated:
            evidence.flags[key] = TriggerFlag(why=message(WriteFault.REPEATED.value))
    evidence.rejected_bytes = end.rejected_bytes - begin.rejected_bytes
    evidence.ended_at = end.now


def _has_stream() -> Procedure[bool]:
    """Whether reports come while none is asked for. A second module's come only as answers; a stream may have begun
    during this check."""
    view: EngineView = yield Inspect()
    if not view.conversation.is_streaming:
        return False
    quiet_since = yield Pause(QUIET_S)  # by now what was asked for before has been answered, twice
    yield Pause(QUIET_S)
    view = yield Inspect()
    tilt = view.conversation.values["tilt_deg"]
    return tilt.how is How.STREAMED and tilt.at >= quiet_since


def activate_ready(ready: Assessment, journal: Journal, permit: Permit) -> Procedure[tuple[Performed, Evidence]]:
    """Activate a module that is READY, once, and read everything again, in the conversation in which the triggers were
    enabled. Returns the evidence to be judged: that of READY where an interlock refused it; void where READY no longer
    held, so that nothing was sent, where the conversation ended, or where the module does not report that it is
    active."""
    evidence = ready.case.evidence
    begin: EngineView = yield Inspect()
    void = void_reason(ready, begin.conversation, begin.now)
    if void is not None:
        refusal = Refusal(Interlock.CONFIRMED, message(marked("Void: {why}"), why=void.message))
        refused = Performed(act=Act.ACTIVATE, outcome=Outcome.NOT_SENT, refusals=(refusal,))
        return refused, replace(evidence, void=void)
    performed = yield from perform(Act.ACTIVATE, journal, permit=permit)
    if performed.interrupted is not None:
        return performed, replace(evidence, void=void_of_end(performed.interrupted))
    if performed.outcome is Outcome.NOT_SENT:
        return performed, evidence
    try:
        yield Pause(SETTLE_S)
        state = yield from read_state()
        end: EngineView = yield Inspect()
    except Interrupted as error:
        return performed, replace(evidence, void=void_of_end(error))
    void = void_reason(ready, end.conversation, end.now)
    if void is None and (not state.is_complete or state.status is None or not state.status.active):
        void = UNREAD
    return performed, replace(evidence, status=state.status or evidence.status, void=void)
