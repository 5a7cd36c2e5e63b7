"""From READY to GO in the connection in which the triggers were enabled."""

from dataclasses import replace

from app.engine.procedure import EngineView, Inspect, Procedure, pause_asking
from app.preflight.evidence import Disturbance, Evidence
from app.preflight.reread import read_state
from app.preflight.verdict import Assessment, Void, void_of_reading, void_reason
from app.procedures.act import Performed, perform
from app.safety.acts import Act
from app.safety.interlocks import Interlock, Refusal
from app.safety.journal import Journal, Outcome
from app.safety.permit import Permit
from app.text.messages import message
from protocol.translatable import marked

SETTLE_S = 0.6
"""A module that restarts when it is activated has said so by then, with two heartbeats."""


def activate_ready(ready: Assessment, journal: Journal, permit: Permit) -> Procedure[tuple[Performed, Evidence]]:
    """Activate a module that is READY, once, and read everything again. Returns the evidence to be judged: that of
    READY where an interlock refused it; void where READY no longer held, so that nothing was sent, where something else
    changed, or where the module does not report that it is active."""
    evidence = ready.case.evidence
    begin: EngineView = yield Inspect()
    void = void_reason(ready, begin.device, begin.now, opened_at=begin.opened_at)
    if void is not None:
        refusal = Refusal(Interlock.IS_IDENTITY_SETTLED, message(marked("Void: {why}."), why=void.message))
        refused = Performed(act=Act.ACTIVATE, outcome=Outcome.NOT_SENT, refusals=(refusal,))
        return refused, replace(evidence, disturbance=void.reason)
    performed = yield from perform(Act.ACTIVATE, journal, permit=permit)
    if performed.outcome is Outcome.NOT_SENT:
        return performed, evidence
    yield from pause_asking(SETTLE_S)
    state = yield from read_state()
    end: EngineView = yield Inspect()
    void = void_reason(ready, end.device, end.now, opened_at=end.opened_at) or void_of_reading(evidence, state)
    if void is None and (state.status is None or not state.status.active):
        void = Void(Disturbance.UNREAD)
    reason = evidence.disturbance if void is None else void.reason
    return performed, replace(evidence, status=state.status or evidence.status, disturbance=reason)
