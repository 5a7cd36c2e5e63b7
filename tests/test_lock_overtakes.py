"""LOCK goes before everything else, and nothing dangerous that was asked for before it follows."""

import pytest

from app.acts import REQUESTS, Act
from app.journal import Outcome
from app.permit import Origin, Permit
from app.procedures.act import Performed, perform
from app.procedures.baud import BaudEnd, change_baud
from app.procedures.lock import Locked, lock
from app.safety import Condition, Situation, refusals
from app.session import Run
from protocol.catalogue import HEARTBEAT, Hazard
from protocol.link_states import Presence
from tests.journals import FakeJournal
from tests.sim_line import Rig

SLOW = {"delay_ms": 60.0}
WHY = "LOCK was pressed after this was confirmed: confirm again."


def under_way(rig: Rig, act: Act) -> Run[Performed]:
    permit = Permit(act, Origin.CONFIRMATION, rig.clock())
    run: Run[Performed] = Run(perform(act, FakeJournal(), permit=permit))
    rig.session.run(run)
    return run


def press_lock(rig: Rig) -> Run[Locked]:
    run: Run[Locked] = Run(lock())
    rig.session.run(run, is_urgent=True)
    return run


@pytest.mark.parametrize("act", [Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY])
@pytest.mark.parametrize("steps", range(0, 24, 2))
def test_nothing_dangerous_leaves_after_lock_was_pressed(act: Act, steps: int) -> None:
    rig = Rig(SLOW)
    performing = under_way(rig, act)
    for _ in range(steps):
        rig.session.step()
    before = rig.line.requests
    locking = press_lock(rig)
    rig.step_until(lambda: performing.is_done and locking.is_done)
    assert not [request for request in rig.line.requests[len(before) :] if request.hazard is Hazard.DANGEROUS]
    assert performing.result is not None
    if REQUESTS[act] in before:
        return
    assert performing.result.outcome is Outcome.NOT_SENT
    assert [one.condition for one in performing.result.refusals] == [Condition.CONFIRMED]
    assert not rig.bench.module.state.is_active


def test_the_baud_rate_is_not_changed_after_lock_was_pressed() -> None:
    rig = Rig(SLOW)
    permit = Permit(Act.CHANGE_BAUD, Origin.CONFIRMATION, rig.clock())
    changing = Run(change_baud(9600, FakeJournal(), permit=permit))
    rig.session.run(changing)
    press_lock(rig)
    rig.step_until(lambda: changing.is_done)
    assert changing.result is not None
    assert changing.result.end is BaudEnd.NOT_SENT


def test_what_is_confirmed_after_lock_is_done() -> None:
    rig = Rig(SLOW)
    press_lock(rig)
    rig.step_for(1.0)
    permit = Permit(Act.ZERO, Origin.CONFIRMATION, rig.clock())
    done = rig.run(perform(Act.ZERO, FakeJournal(), permit=permit))
    assert done.outcome is Outcome.CONFIRMED


def test_an_act_that_waits_for_the_line_is_withheld() -> None:
    """The link's own heartbeat is out when the act is decided; LOCK comes before the answer to it."""
    rig = Rig(SLOW)
    performing = under_way(rig, Act.ZERO)
    rig.step_until(lambda: rig.line.requests[-1:] != [HEARTBEAT.query()] and performing.resume_at is not None)
    rig.session._link._probe_at = rig.clock()
    rig.session._link.tick(rig.clock())
    rig.session.step(0.0)
    assert performing.wants_to_ask is not None
    assert performing.wants_to_ask.request == REQUESTS[Act.ZERO]
    press_lock(rig)
    rig.step_until(lambda: performing.is_done)
    assert REQUESTS[Act.ZERO] not in rig.line.requests
    assert performing.result is not None
    assert performing.result.outcome is Outcome.NOT_SENT


@pytest.mark.parametrize("act", [Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY])
def test_what_was_confirmed_before_the_port_was_opened_is_not_done(act: Act) -> None:
    """By now another module may be connected; found by the stateful test."""
    rig = Rig()
    permit = Permit(act, Origin.CONFIRMATION, rig.session.opened_at - 0.01)
    done = rig.run(perform(act, FakeJournal(), permit=permit))
    assert done.outcome is Outcome.NOT_SENT
    assert [one.sentence for one in done.refusals] == [
        "The port was opened anew after this was confirmed: confirm again."
    ]
    assert REQUESTS[act] not in rig.line.requests


def test_it_is_said_why() -> None:
    """The permit alone is good, and LOCK came after it."""
    permit = Permit(Act.ZERO, Origin.CONFIRMATION, 100.0)
    for overtaken_at, said in ((99.0, []), (100.0, [WHY]), (100.5, [WHY]), (None, [])):
        now_is = Situation(
            now=101.0, presence=Presence.ONLINE, status_at=101.0, active=False, permit=permit, overtaken_at=overtaken_at
        )
        assert [one.sentence for one in refusals(Act.ZERO, now_is)] == said


def test_what_was_confirmed_before_the_computer_slept_is_not_done() -> None:
    permit = Permit(Act.ZERO, Origin.CONFIRMATION, 100.0)
    for slept_until, said in ((99.0, []), (100.5, ["The computer slept after this was confirmed: confirm again."])):
        now_is = Situation(
            now=101.0, presence=Presence.ONLINE, status_at=101.0, active=False, permit=permit, slept_until=slept_until
        )
        assert [one.sentence for one in refusals(Act.ZERO, now_is)] == said
