"""Zeroing: only a module that lies level and still, and afterwards the tilt is read and said."""

import pytest

from app.engine.device import StatusSample
from app.engine.motion import MotionExtremes, MotionWatch
from app.engine.session import Run
from app.procedures.act import Performed, perform
from app.safety.acts import REQUESTS, Act
from app.safety.interlocks import Interlock
from app.safety.journal import Outcome
from app.safety.permit import Origin, Permit
from protocol.catalogue import STATUS
from protocol.messages import Status
from tests.support.journals import FakeJournal
from tests.support.line.sim_line import Rig, end_watch, settled_rig, watched
from ui.acts.outcomes import outcome_meaning
from ui.style.theme import Meaning


def begin(rig: Rig) -> Run[Performed]:
    permit = Permit(Act.ZERO, Origin.CONFIRMATION, rig.clock())
    run: Run[Performed] = Run(perform(Act.ZERO, FakeJournal(), permit=permit))
    rig.session.run(run)
    return run


def end(rig: Rig, run: Run[Performed]) -> Performed:
    rig.step_until(lambda: run.is_done)
    assert run.result is not None
    return run.result


@pytest.mark.parametrize("is_streaming", [False, True])
def test_two_seconds_of_reports_are_asked_for_first(is_streaming: bool) -> None:
    rig = settled_rig(tilt=4)
    if is_streaming:
        watched(rig)
    before = len(rig.line.requests)
    done = end(rig, begin(rig))
    asked = rig.line.requests[before:]
    assert asked[: asked.index(REQUESTS[Act.ZERO])].count(STATUS.query()) >= 20
    if is_streaming:
        end_watch(rig)
    assert done.outcome is Outcome.CONFIRMED
    assert (done.sentence, outcome_meaning(done)) == ("Acknowledged. Tilt now 0°.", Meaning.GOOD)


def test_a_swinging_module_is_not_zeroed() -> None:
    rig = settled_rig(tilt=0)
    run = begin(rig)
    for turn in range(24):
        rig.bench.set_tilt(8 if turn % 2 else 2)
        rig.step_for(0.13)
    done = end(rig, run)
    assert done.outcome is Outcome.NOT_SENT
    assert [one.condition for one in done.refusals] == [Interlock.IS_STILL]
    assert "It moves: 2–8°" in done.sentence
    assert rig.bench.module.memory.zero_tilt_deg == 0


@pytest.mark.parametrize("tilt", [10, 11, 26])
def test_only_a_small_mounting_error_is_zeroed(tilt: int) -> None:
    rig = settled_rig(tilt=tilt)
    done = end(rig, begin(rig))
    assert (done.outcome is Outcome.CONFIRMED) is (tilt == 10)
    assert [one.condition for one in done.refusals] == ([] if tilt == 10 else [Interlock.IS_LEVEL])


def test_it_moves_at_the_last_moment() -> None:
    """What streams in counts as well: it moved, whoever asked."""
    rig = settled_rig(tilt=3)
    switch = watched(rig)
    run = begin(rig)
    rig.step_for(1.9)
    rig.bench.set_tilt(7)
    done = end(rig, run)
    assert [one.condition for one in done.refusals] == [Interlock.IS_STILL]
    assert switch is not None
    end_watch(rig)


def test_the_tilt_is_read_afterwards_and_nothing_is_promised() -> None:
    done = Performed(act=Act.ZERO, outcome=Outcome.CONFIRMED, status=StatusSample(0.0, 7, 1.0, False, False))
    assert done.sentence == "Acknowledged. Tilt now 7°, not 0°: check the mounting."
    assert outcome_meaning(done) is Meaning.ATTENTION
    unread = Performed(act=Act.ZERO, outcome=Outcome.CONFIRMED)
    assert unread.sentence == "Acknowledged. Could not read the tilt: check it."
    assert outcome_meaning(unread) is Meaning.ATTENTION


def test_the_watch_forgets_what_is_old_and_misses_no_extreme() -> None:
    watch = MotionWatch()
    for step in range(4000):
        tilt = 30 if step == 700 else 5
        watch.feed(Status(tilt, 0.3 if step == 2600 else 1.0, triggered=False, active=False), step / 1000)
    assert watch.view(3.0) == MotionExtremes(0.401, 3.999, 5, 30, 0.3, 1.0)
    later = watch.view(4.0)
    assert later is not None
    assert (later.tilt_high_deg, later.acceleration_low_g) == (5, 0.3)
    assert watch.view(9.0) is None
