"""The end of a conversation: what ends with it, what goes on, and how the next one begins."""

from collections.abc import Callable
from contextlib import suppress

import pytest

from app.engine.conversation import Interrupted
from app.engine.procedure import Ask, Inspect, Pause, Procedure, UseRate
from app.procedures.lock import lock
from protocol.catalogue import ACTIVATION, BY_NAME, HEARTBEAT, LOCK, STATUS, Request
from protocol.events import Answered, Began, Ended, EndReason, Unanswered
from tests.support.line.frames import at_each_frame, restart_silently
from tests.support.line.sim_line import Rig, settled_rig
from tests.unit.protocol.link_bench import BOOTS

LIGHT = BY_NAME["light"].query()
SET = BY_NAME["freefall_time"].set(1.2)
ACTIVATE = ACTIVATION.set(True)


def other_rate() -> Procedure[None]:
    yield UseRate(9600)
    yield UseRate(115200)


def leap(rig: Rig, seconds: float) -> None:
    """The computer slept, or this program stood still."""
    rig.clock.now_s += seconds
    rig.step_for(0.1)


def restart(rig: Rig) -> None:
    rig.bench.restart()
    rig.step_for(0.5)


def restart_unheard(rig: Rig) -> None:
    restart_silently(rig.bench)
    rig.step_for(1.5)


def contradict(rig: Rig) -> None:
    rig.bench.module.memory.boot_count -= 10
    rig.step_for(1.5)


End = Callable[[Rig], object]
ON_THE_PORT: dict[str, tuple[End, EndReason]] = {
    "silent": (lambda rig: rig.silence(0.6), EndReason.SILENT),
    "restarted": (restart, EndReason.RESTARTED),
    "silently restarted": (restart_unheard, EndReason.RESTARTED),
    "contradicted": (contradict, EndReason.CONTRADICTED),
    "slept": (lambda rig: leap(rig, 60.0), EndReason.SLEPT),
    "stood still": (lambda rig: leap(rig, 1.2), EndReason.SILENT),
    "said by a person": (lambda rig: rig.session.treat_as_another(), EndReason.ANOTHER),
    "at another rate": (
        lambda rig: rig.end(rig.job(other_rate(), is_urgent=True, outlives=True)),
        EndReason.RATE_CHANGED,
    ),
}
OF_THE_PORT: dict[str, End] = {
    "lost": lambda rig: rig.session.close(EndReason.PORT_LOST),
    "closed": lambda rig: rig.session.close(EndReason.CLOSED),
}
on_the_port = pytest.mark.parametrize(("end", "reason"), ON_THE_PORT.values(), ids=ON_THE_PORT)
whatever_ends_it = pytest.mark.parametrize("end", [end for end, _ in ON_THE_PORT.values()], ids=ON_THE_PORT)
ENDS = {how: end for how, (end, _) in ON_THE_PORT.items()} | OF_THE_PORT


def rest() -> Procedure[None]:
    """Ask now and then, as long as it is let."""
    while True:
        yield Ask(LIGHT)
        yield Pause(0.02)


def stubborn() -> Procedure[None]:
    """It wants to undo something, whatever happens."""
    try:
        yield from rest()
    finally:
        yield Ask(SET)


def sent_since(rig: Rig, count: int) -> list[Request]:
    return [request for request in rig.line.requests[count:] if request not in (BOOTS, HEARTBEAT.query())]


@whatever_ends_it
@pytest.mark.promise("f")
def test_the_next_one_begins_by_itself_with_nothing_known(end: End) -> None:
    rig = settled_rig()
    rig.run(_ask(BY_NAME["attitude_threshold"].query()))
    assert "attitude_threshold_deg" in rig.conversation.values
    end(rig)
    rig.step_until(lambda: rig.conversation.is_going, limit_s=2.0)
    assert rig.conversation.number == 2
    assert set(rig.conversation.values) == {"boot_count", "baud_rate"}
    kinds = [type(event) for event in rig.session.events if isinstance(event, Began | Ended)]
    assert kinds == [Began, Ended, Began]


@on_the_port
@pytest.mark.promise("f")
def test_what_a_job_wants_to_undo_reaches_nobody(end: End, reason: EndReason) -> None:
    rig = settled_rig()
    job, queued = rig.job(stubborn()), rig.job(_ask(SET))
    rig.step_for(0.2)
    end(rig)
    rig.step_for(2.0)
    for one in (job, queued):
        assert isinstance(one.error, Interrupted)
        assert one.error.reason is reason
    assert SET not in rig.line.requests


@whatever_ends_it
@pytest.mark.promise("f")
def test_a_job_that_was_decided_before_does_not_start_after(end: End) -> None:
    rig = settled_rig()
    number = rig.conversation.number
    end(rig)
    rig.step_until(lambda: rig.conversation.is_going, limit_s=2.0)
    sent = len(rig.line.requests)
    job = rig.job(_ask(SET), conversation=number)
    rig.step_for(0.5)
    assert isinstance(job.error, Interrupted)
    assert sent_since(rig, sent) == []


@on_the_port
@pytest.mark.promise("f")
def test_who_expects_the_reason_goes_on_with_questions_only(end: End, reason: EndReason) -> None:
    def expecting() -> Procedure[list[object]]:
        with suppress(Interrupted):
            yield from rest()
        view = yield Inspect()
        while not view.conversation.is_going:
            yield Pause(0.05)
            view = yield Inspect()
        answered = yield Ask(STATUS.query())
        refused = yield Ask(SET)
        return [answered, refused]

    rig = settled_rig()
    job = rig.job(expecting(), expects=frozenset({reason}))
    rig.step_for(0.1)
    end(rig)
    answered, refused = rig.end(job, limit_s=5.0)
    assert isinstance(answered, Answered)
    assert refused == Unanswered(SET, 0, 0.0, refused.at)  # type: ignore[attr-defined]
    assert SET not in rig.line.requests


@pytest.mark.promise("f")
@pytest.mark.parametrize("is_held", [True, False])
def test_it_is_told_whether_a_set_had_left(is_held: bool) -> None:
    def writing() -> Procedure[bool]:
        yield Ask(LIGHT)
        try:
            yield Ask(SET)
        except Interrupted as interrupted:
            return interrupted.is_unsent
        raise AssertionError

    rig = settled_rig()
    rig.bench.change(lag_ms=100.0)
    job = rig.job(writing())
    if is_held:
        rig.step_until(lambda: job.pending_ask is not None and job.pending_ask.request == SET)
    else:
        rig.step_until(lambda: SET in rig.line.requests)
    rig.session.treat_as_another()
    assert job.outcome() is is_held
    rig.step_for(1.0)
    assert rig.line.requests.count(SET) == (not is_held)


@pytest.mark.parametrize(
    "how", ["restarted", "slept", "stood still", "said by a person", "at another rate", *OF_THE_PORT]
)
@pytest.mark.promise("i")
def test_an_act_that_waits_for_a_quiet_line_does_not_leave_after_the_end(how: str) -> None:
    def acting() -> Procedure[None]:
        yield Ask(LIGHT)
        yield Ask(ACTIVATE, is_deliberate=True)

    rig = settled_rig()
    job = rig.job(acting())
    rig.step_until(lambda: job.pending_ask is not None and job.pending_ask.request == ACTIVATE)
    ENDS[how](rig)
    if not rig.line.is_closed:
        rig.step_for(1.0)
    assert ACTIVATE not in rig.line.requests


# LOCK that is owed


def _ask(*requests: Request) -> Procedure[None]:
    for request in requests:
        yield Ask(request, is_deliberate=True)


def activating() -> Procedure[None]:
    yield Ask(ACTIVATE, is_deliberate=True)
    yield Pause(10.0)


@pytest.mark.parametrize("end", ENDS.values(), ids=ENDS)
@pytest.mark.promise("j")
def test_an_interrupted_activation_leaves_lock_owed(end: End) -> None:
    rig = settled_rig()
    rig.job(activating())
    rig.step_for(0.2)
    assert not rig.session.owes_lock
    end(rig)
    assert rig.session.owes_lock


@pytest.mark.promise("j")
def test_lock_itself_is_owed_when_the_port_is_lost() -> None:
    rig = settled_rig(active=True)
    at_each_frame(rig.bench, lambda request: request != LOCK)
    rig.job(lock(), is_urgent=True, outlives=True)
    rig.step_for(0.2)
    rig.session.close(EndReason.PORT_LOST)
    assert rig.session.owes_lock
