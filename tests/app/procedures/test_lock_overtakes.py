"""LOCK goes before everything else, and nothing dangerous that was asked for before it follows."""

from collections.abc import Callable

import pytest

from app.engine.procedure import Ask, PortLost, Procedure
from app.engine.session import Run
from app.procedures.act import Performed, perform
from app.procedures.baud import BaudEnd, change_baud
from app.procedures.lock import Locked, lock
from app.procedures.write import SetReply, read_back, write_verified
from app.safety.acts import REQUESTS, Act
from app.safety.interlocks import Interlock
from app.safety.journal import Outcome
from app.safety.permit import Origin, Permit
from protocol.catalogue import BY_NAME, Hazard, Request
from protocol.events import Outcome as Ended
from protocol.events import Unanswered
from protocol.link_states import Exchange
from tests.support.journals import FakeJournal
from tests.support.line.odd_module import end_faults
from tests.support.line.sim_line import Rig

SLOW = {"delay_ms": 60.0}
LIGHT_THRESHOLD = BY_NAME["light_threshold"]


def under_way(rig: Rig, act: Act) -> Run[Performed]:
    return rig.started(perform(act, FakeJournal(), permit=rig.permit(act)))


def press_lock(rig: Rig) -> Run[Locked]:
    return rig.started(lock(), is_urgent=True)


@pytest.mark.parametrize("act", [Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY])
@pytest.mark.parametrize("steps", range(0, 24, 2))
@pytest.mark.promise("e")
def test_nothing_dangerous_leaves_after_lock_was_pressed(act: Act, steps: int) -> None:
    rig = Rig(SLOW)
    performing = under_way(rig, act)
    for _ in range(steps):
        rig.session.step()
    before = rig.line.requests
    locking = press_lock(rig)
    rig.step_until(lambda: performing.is_done and locking.is_done)
    assert not [request for request in rig.line.requests[len(before) :] if request.hazard is Hazard.DANGEROUS]
    performed = rig.end(performing)
    if REQUESTS[act] in before:
        return
    assert performed.outcome is Outcome.NOT_SENT
    refused = [refusal.condition for refusal in performed.refusals]
    assert refused in ([Interlock.CONFIRMED], [])  # none where it was waiting for a quiet line
    assert not rig.bench.module.state.is_active


@pytest.mark.parametrize("act", [Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY])
@pytest.mark.parametrize("why", ["cancelled", "port lost"])
def test_what_is_broken_off_while_it_waits_for_a_quiet_line_was_not_sent(act: Act, why: str) -> None:
    rig = Rig()
    performing = under_way(rig, act)
    while performing.pending_ask is None or performing.pending_ask.request != REQUESTS[act]:
        rig.session.step()
    if why == "cancelled":
        performing.cancel()
        rig.step_for(0.2)
    else:
        rig.session.close(why=PortLost())
    assert performing.result == Performed(act=act, outcome=Outcome.NOT_SENT)
    assert REQUESTS[act] not in rig.line.requests


def test_the_baud_rate_is_not_changed_after_lock_was_pressed() -> None:
    rig = Rig(SLOW)
    changing = rig.started(change_baud(9600, FakeJournal(), permit=rig.permit(Act.CHANGE_BAUD)))
    press_lock(rig)
    assert rig.end(changing).end is BaudEnd.NOT_SENT


def test_what_is_confirmed_after_lock_is_done() -> None:
    rig = Rig(SLOW)
    press_lock(rig)
    rig.step_for(1.0)
    done = rig.run(perform(Act.ZERO, FakeJournal(), permit=rig.permit(Act.ZERO)))
    assert done.outcome is Outcome.CONFIRMED


def test_an_act_that_waits_for_the_line_is_withheld() -> None:
    """The link's own heartbeat is out when the act is decided; LOCK comes before the answer to it."""
    rig = Rig(SLOW)
    performing = under_way(rig, Act.SHUTDOWN)
    boots = BY_NAME["boot_count"].query()  # the last question before the act
    rig.step_until(lambda: rig.line.requests[-1:] == [boots] and performing.resume_at is not None)
    rig.session._link._probe_at = rig.clock()
    rig.session._link.tick(rig.clock())
    rig.session.step(0.0)
    assert performing.pending_ask is not None
    assert performing.pending_ask.request == REQUESTS[Act.SHUTDOWN]
    press_lock(rig)
    ended = rig.end(performing)
    assert REQUESTS[Act.SHUTDOWN] not in rig.line.requests
    assert ended.outcome is Outcome.NOT_SENT


@pytest.mark.parametrize("act", [Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY])
@pytest.mark.parametrize("before_s", [0.01, 0.0])
@pytest.mark.promise("a")
def test_what_was_confirmed_before_the_port_was_opened_is_not_done(act: Act, before_s: float) -> None:
    """By now another module may be connected; at the very same moment nobody knows which came first."""
    rig = Rig()
    permit = Permit(act, Origin.CONFIRMATION, rig.session.opened_at - before_s)
    done = rig.run(perform(act, FakeJournal(), permit=permit))
    assert done.outcome is Outcome.NOT_SENT
    assert [refusal.sentence for refusal in done.refusals] == ["Confirm again: port reopened."]
    assert REQUESTS[act] not in rig.line.requests


def heartbeat_of_the_link(rig: Rig) -> None:
    rig.step_until(lambda: rig.session._link.exchange is Exchange.PROBING)


def ask_at_once(request: Request) -> Procedure[Ended]:
    outcome: Ended = yield Ask(request, is_deliberate=True)
    return outcome


def set_in_flight(rig: Rig) -> None:
    rig.session.run(Run(ask_at_once(LIGHT_THRESHOLD.set(2.0))))
    rig.step_until(lambda: rig.line.requests[-1:] == [LIGHT_THRESHOLD.set(2.0)])


def read_back_behind_a_fence(rig: Rig) -> None:
    """The set was unanswered, and its acknowledgement must not pass for the value read back."""
    set_in_flight(rig)
    rig.session.run(Run(ask_at_once(LIGHT_THRESHOLD.query())))
    rig.step_until(lambda: rig.session._link.exchange is Exchange.FENCING)


@pytest.mark.parametrize("wait", [heartbeat_of_the_link, set_in_flight, read_back_behind_a_fence])
@pytest.mark.promise("j")
def test_lock_waits_for_no_answer(wait: Callable[[Rig], object]) -> None:
    """The module hears and its answers are lost: each of them is waited for up to a second, or three."""
    rig = Rig({"active": True})
    rig.step_for(1.0)
    rig.bench.change(drop=1.0)
    wait(rig)
    sent = len(rig.line.requests)
    press_lock(rig)
    rig.session.step(0.0)
    assert rig.line.requests[sent:] == [REQUESTS[Act.LOCK]]
    rig.step_for(0.01)
    assert not rig.bench.module.state.is_active


def test_lock_pressed_again_leaves_at_once_and_takes_the_place_of_the_first() -> None:
    rig = Rig({"active": True})
    rig.step_for(1)
    rig.bench.change(mute=True)
    first = press_lock(rig)
    rig.step_until(lambda: rig.line.requests.count(REQUESTS[Act.LOCK]) == 1)
    second = press_lock(rig)
    rig.session.step(0.0)
    assert rig.line.requests.count(REQUESTS[Act.LOCK]) == 2
    end_faults(rig.bench)
    assert rig.end(first).is_replaced
    assert rig.end(second).is_locked


def test_a_set_that_lock_overtakes_is_not_sent_again_and_is_read_back() -> None:
    rig = Rig(SLOW)
    rig.run(read_back(LIGHT_THRESHOLD))
    writing = rig.started(write_verified(LIGHT_THRESHOLD, 2.0))
    rig.step_until(lambda: rig.line.requests[-1:] == [LIGHT_THRESHOLD.set(2.0)])
    press_lock(rig)
    ended = rig.end(writing)
    assert rig.line.requests.count(LIGHT_THRESHOLD.set(2.0)) == 1
    assert (ended.heard, ended.verified) == (SetReply.NOTHING, True)


def test_an_act_that_lock_overtakes_is_of_unknown_outcome_until_the_module_tells() -> None:
    rig = Rig(SLOW)
    performing = under_way(rig, Act.ACTIVATE)
    rig.step_until(lambda: rig.line.requests[-1:] == [REQUESTS[Act.ACTIVATE]])
    locking = press_lock(rig)
    assert rig.end(performing).outcome is Outcome.UNKNOWN
    assert rig.end(locking).is_locked
    assert rig.line.requests.count(REQUESTS[Act.ACTIVATE]) == 1
    assert not rig.bench.module.state.is_active


@pytest.mark.promise("e")
def test_what_is_dangerous_and_waits_behind_a_fence_is_withheld() -> None:
    rig = Rig(SLOW)
    rig.bench.change(drop=1.0)
    rig.started(ask_at_once(REQUESTS[Act.ACTIVATE]))
    again = rig.started(ask_at_once(REQUESTS[Act.ACTIVATE]))
    rig.step_until(lambda: rig.session._link.exchange is Exchange.FENCING)
    assert rig.line.requests.count(REQUESTS[Act.ACTIVATE]) == 1
    end_faults(rig.bench)
    press_lock(rig)
    ended = rig.end(again)
    rig.step_for(3.0)
    assert rig.line.requests.count(REQUESTS[Act.ACTIVATE]) == 1
    assert isinstance(ended, Unanswered)
    assert ended.attempts == 0
    assert not rig.bench.module.state.is_active
