"""A trigger counts as enabled only within the unbroken conversation in which the module acknowledged it (E8)."""

from collections.abc import Callable

import pytest

from app.engine.procedure import Ask, Procedure
from app.preflight.evidence import Evidence, FlagState, FrameLog
from app.preflight.run import TRIGGERS, run_preflight
from app.preflight.verdict import Verdict
from app.simulator.bench import SimulatedBench
from app.simulator.setup import Setup
from protocol.catalogue import HEARTBEAT
from tests.support.check_pace import hurry_check
from tests.support.line.sim_line import Rig
from tests.support.records.preflight_rig import Measured, judged

OPTIONS = {"uptime": 60, "noise": 0}


def checked(rig: Rig, *, is_enabling: bool = False) -> tuple[Verdict, Evidence]:
    evidence = Evidence(port="sim")
    rig.run(run_preflight(evidence, is_enabling=is_enabling))
    return judged(Measured(rig, evidence, FrameLog())).assessment.verdict, evidence


def twin(rig: Rig, *, boots: int = 37) -> SimulatedBench:
    """Another module: the same boot count and settings, its triggers never enabled."""
    return SimulatedBench(Setup(uptime=60.0, noise=0.0, boots=boots), clock=rig.clock)


def exchange(rig: Rig, other: SimulatedBench, silent_s: float) -> None:
    """Nothing arrives for this long; then the other module answers."""
    line, write, at = rig.line, rig.line.write, rig.clock.now_s + silent_s

    def written(data: bytes) -> None:
        if rig.clock.now_s >= at:
            line.bench = other
            write(data)

    line.write = written  # type: ignore[method-assign]
    rig.bench.wire.clear(rig.clock.now_s)


def at_request(rig: Rig, number: int, act: Callable[[], None]) -> None:
    write = rig.line.write

    def counted(data: bytes) -> None:
        nonlocal number
        number -= 1
        if number == 0:
            act()
        rig.line.write(data) if number == 0 else write(data)

    rig.line.write = counted  # type: ignore[method-assign]


def test_ready_holds_in_the_conversation_in_which_they_were_enabled() -> None:
    rig = Rig(OPTIONS)
    assert checked(rig, is_enabling=True)[0] is Verdict.READY
    rig.step_for(30)
    assert checked(rig)[0] is Verdict.READY
    rig.bench.module.activate(is_active=True)
    assert checked(rig)[0] is Verdict.GO


@pytest.mark.parametrize("is_active", [False, True])
def test_a_new_opening_of_the_port_knows_nothing(is_active: bool) -> None:
    rig = Rig(OPTIONS)
    assert checked(rig, is_enabling=True)[0] is Verdict.READY
    again = Rig(OPTIONS)
    again.bench.module.activate(is_active=is_active)
    verdict, evidence = checked(again)
    assert verdict is Verdict.NO_GO
    assert {evidence.flags[command.key].state for command in TRIGGERS} == {FlagState.NEVER_SET}


def test_a_restart_that_the_boot_count_does_not_count() -> None:
    """A brown-out or a watchdog: only two heartbeats tell."""
    rig = Rig(OPTIONS)
    assert checked(rig, is_enabling=True)[0] is Verdict.READY
    rig.bench.module.memory.boot_count -= 1
    rig.bench.restart()
    rig.step_for(2)
    assert rig.bench.module.memory.boot_count == 37
    verdict, evidence = checked(rig)
    assert (verdict, evidence.values["boot_count"]) == (Verdict.NO_GO, 37)


@pytest.mark.parametrize("silent_s", [0.2, 0.3, 0.5, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("is_active", [False, True])
def test_a_twin_put_in_its_place_between_two_checks(silent_s: float, is_active: bool) -> None:
    rig = Rig(OPTIONS)
    assert checked(rig, is_enabling=True)[0] is Verdict.READY
    other = twin(rig)
    other.module.activate(is_active=is_active)
    exchange(rig, other, silent_s)
    verdict, evidence = checked(rig)
    assert rig.line.bench is other
    assert (verdict, evidence.values["boot_count"]) == (Verdict.NO_GO, 37)


@pytest.mark.parametrize("silent_s", [0.35, 0.5, 1.0, 1.5, 2.0])
def test_a_twin_put_in_its_place_in_the_middle_of_a_check(silent_s: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """At every request after the heartbeats, until nothing is asked of the other one any more."""
    hurry_check(monkeypatch)
    whole = Rig(OPTIONS)
    assert checked(whole, is_enabling=True)[0] is Verdict.READY
    begin = 25
    for number in range(begin, len(whole.line.requests), 7):
        rig = Rig(OPTIONS)
        other = twin(rig)
        at_request(rig, number, lambda rig=rig, other=other: exchange(rig, other, silent_s))  # type: ignore[misc]
        assert checked(rig, is_enabling=True)[0] is Verdict.NO_GO, (number, whole.line.requests[number - 1])


def test_a_module_of_another_start_put_in_its_place_without_any_silence() -> None:
    whole = Rig(OPTIONS)
    checked(whole, is_enabling=True)
    for number in range(25, len(whole.line.requests) - 12, 3):
        rig = Rig(OPTIONS)
        other = twin(rig, boots=38)
        at_request(rig, number, lambda rig=rig, other=other: exchange(rig, other, 0.0))  # type: ignore[misc]
        assert checked(rig, is_enabling=True)[0] is Verdict.NO_GO, number


def test_a_module_that_does_not_answer_the_question_for_its_records_stays_known() -> None:
    rig = Rig(OPTIONS | {"mute_codes": "35"})
    _verdict, evidence = checked(rig, is_enabling=True)
    assert evidence.disturbance is None
    assert {evidence.flags[command.key].state for command in TRIGGERS} == {FlagState.ENABLED}


def test_one_lost_answer_breaks_nothing_and_an_unanswered_second_does() -> None:
    rig = Rig(OPTIONS)
    assert checked(rig, is_enabling=True)[0] is Verdict.READY
    breaks = rig.session.device.view(rig.clock.now_s).breaks
    for wait_s, is_broken in ((0.2, False), (1.0, True)):
        rig.bench.change(mute=True)
        rig.run(_ask_once(wait_s))
        rig.bench.end_faults()
        rig.run(_ask_once(1.0))
        view = rig.session.device.view(rig.clock.now_s)
        assert (view.breaks > breaks) is is_broken
        assert (TRIGGERS[0].key in view.values) is not is_broken


def _ask_once(wait_s: float) -> Procedure[None]:
    yield Ask(HEARTBEAT.query(), (wait_s,))
