"""From READY to GO in the conversation in which the triggers were enabled."""

from dataclasses import replace

from app.engine.conversation import Interrupted
from app.engine.procedure import EngineView, Inspect, Pause, Procedure
from app.preflight.evidence import UNREAD, Evidence, read_state, void_of_end
from app.preflight.verdict import Assessment, void_reason
from app.procedures.act import Performed, perform
from app.safety.acts import Act
from app.safety.interlocks import Interlock, Refusal
from app.safety.journal import Journal, Outcome
from app.safety.permit import Permit
from app.text.messages import message
from protocol.translatable import marked

# A module that restarts when it is activated has said so by then.
SETTLE_S = 0.6


def activate_ready(ready: Assessment, journal: Journal, permit: Permit) -> Procedure[tuple[Performed, Evidence]]:
    """Activate a module that is READY, once, and read everything again. Returns the evidence to be judged: that of
    READY where an interlock refused it; void where READY no longer held, so that nothing was sent, where the
    conversation ended, or where the module does not report that it is active."""
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
