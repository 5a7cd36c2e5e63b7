"""`dps-s lock`: after a silence or a restart the module that answers now is asked again, by the independent module."""

import pytest

from app.engine.session import Run
from app.procedures.lock import Locked, lock
from app.safety.journal import Outcome
from tests.module.module import Module
from tests.module.options import Options
from tests.support.journals import FakeJournal
from tests.support.line.module_line import ModuleRig

ACTIVATION = 0x10


def active_rig(options: Options | None = None) -> ModuleRig:
    rig = ModuleRig(options or Options(delay_s=0.001))
    rig.module.settings[ACTIVATION] = 1
    return rig


def press(rig: ModuleRig, journal: FakeJournal | None = None) -> Run[Locked]:
    run = Run(lock(journal or FakeJournal(), is_attended=False))
    rig.session.run(run, is_urgent=True)
    return run


@pytest.mark.parametrize("begins_s", [0.0, 0.001, 0.002, 0.003, 0.005, 0.01, 0.1])
@pytest.mark.parametrize("silent_s", [0.3, 0.5, 0.8, 1.5, 3.0])
@pytest.mark.promise("l")
def test_after_a_silence_it_is_locked_if_this_module_reports_it(silent_s: float, begins_s: float) -> None:
    rig, journal = active_rig(), FakeJournal()
    run = press(rig, journal)
    rig.step_for(begins_s)
    rig.module.be_silent(rig.clock(), silent_s)
    locked = rig.end(run)
    assert locked.is_locked
    assert rig.module.settings[ACTIVATION] == 0
    if locked.may_be_another:
        assert locked.sentence == "The module that answers now reports LOCKED."
        assert journal.outcomes == {0: Outcome.UNKNOWN}, "what was left ACTIVE before stays so"


@pytest.mark.parametrize("every_s", [0.002, 0.005, 0.02, 0.1, 0.4])
def test_an_unasked_heartbeat_does_not_keep_it_from_being_locked(every_s: float) -> None:
    rig = active_rig()
    rig.module.options.heartbeat_every_s = every_s
    run = press(rig)
    rig.step_for(every_s + 0.001)
    rig.module.options.heartbeat_every_s = 0.0
    locked = rig.end(run)
    assert locked.is_locked
    assert rig.module.settings[ACTIVATION] == 0


@pytest.mark.parametrize("off_s", [0.1, 0.3, 0.6, 2.0])
@pytest.mark.parametrize("survives", [False, True])
def test_a_restart_meanwhile_is_locked_again(off_s: float, *, survives: bool) -> None:
    rig = active_rig(Options(delay_s=0.001, activation_survives=survives))
    run = press(rig)
    rig.module.restart(rig.clock(), off_s=off_s)
    locked = rig.end(run)
    assert locked.is_locked
    assert rig.module.settings[ACTIVATION] == 0


@pytest.mark.parametrize("gap_s", [0.5, 0.8, 1.5])
@pytest.mark.parametrize("begins_s", [0.0, 0.002, 0.004, 0.006])
@pytest.mark.promise("l")
def test_it_is_never_said_of_another_module_that_does_not_report_it(gap_s: float, begins_s: float) -> None:
    """One that takes its place, is ACTIVE and does not listen to LOCK."""
    rig = active_rig()
    deaf = Module(Options(delay_s=0.001, ignored_sets={ACTIVATION: -1}), name="deaf", now=rig.clock())
    deaf.settings[ACTIVATION] = 1
    run = press(rig)
    rig.step_for(begins_s)
    rig.module.be_silent(rig.clock(), 60.0)
    deaf.be_silent(rig.clock(), gap_s)
    is_done = run.is_done
    rig.line.modules = (deaf,)
    locked = rig.end(run)
    assert is_done or locked.is_locked is not True


@pytest.mark.parametrize("frame", [2, 3])
def test_what_a_locked_module_in_its_place_reports_clears_nothing(frame: int) -> None:
    """The first one heard LOCK, and perhaps reported once; the one that answers then is asked for both reports."""
    rig, journal = active_rig(), FakeJournal()
    other = Module(Options(delay_s=0.001), name="other", now=rig.clock())
    rig.module.at_frame = lambda _question: (
        rig.module.be_silent(rig.clock(), 60.0) if len(rig.module.log.got()) + 1 == frame else None
    )
    run = press(rig, journal)
    rig.step_until(lambda: len(rig.module.log.got()) >= frame)
    other.be_silent(rig.clock(), 0.5)
    rig.line.modules = (other,)
    locked = rig.end(run)
    assert locked.is_locked
    assert locked.sentence == "The module that answers now reports LOCKED."
    assert journal.outcomes == {0: Outcome.UNKNOWN}
    assert other.log.sent(0x30)
    assert other.log.sent(0x32)


def test_what_never_answers_again_is_not_locked() -> None:
    rig = active_rig()
    run = press(rig)
    rig.module.be_silent(rig.clock(), 600.0)
    assert rig.end(run).is_locked is None
