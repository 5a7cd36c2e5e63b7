"""A verdict voids itself: interrupted, disconnected, restarted, changed or too old."""

from collections.abc import Callable

import pytest

from app.preflight.evidence import Disturbance, Evidence
from app.preflight.expectations import Expectations, Past, settings_code
from app.preflight.findings import Case, Result
from app.preflight.run import run_preflight
from app.preflight.verdict import VALID_FOR_S, Assessment, Verdict, Void, assess, void_reason
from app.procedure import Ask, Cancelled, Look, PortLost, Procedure, Sight
from app.procedures.write import write_verified
from app.session import Run
from app.transport import PortError
from protocol.catalogue import BY_NAME, HEARTBEAT, STATUS
from tests.sim_line import Rig


def _sight() -> Procedure[Sight]:
    sight: Sight = yield Look()
    return sight


def _glance() -> Procedure[Sight]:
    """What the window asks for all the time."""
    yield Ask(STATUS.query())
    for name in ("charging", "cell_voltage", "light", "boot_count"):
        yield Ask(BY_NAME[name].query())
    sight: Sight = yield Look()
    return sight


def _heartbeat() -> Procedure[Sight]:
    yield Ask(HEARTBEAT.query(), (1.0,))
    sight: Sight = yield Look()
    return sight


def _assessed(evidence: Evidence) -> Assessment:
    return assess(Case(evidence=evidence, expectations=Expectations(), past=Past(), fingerprint=settings_code))


def _go(rig: Rig) -> Assessment:
    evidence = Evidence()
    rig.run(run_preflight(evidence, is_enabling=True))
    assessment = _assessed(evidence)
    assert assessment.verdict is Verdict.GO
    return assessment


def _void(assessment: Assessment, sight: Sight) -> Void | None:
    return void_reason(assessment, sight.device, sight.now, opened_at=sight.opened_at)


def test_it_stands_while_nothing_happens() -> None:
    rig = Rig()
    assessment = _go(rig)
    assert _void(assessment, rig.run(_sight())) is None
    for _ in range(5):
        rig.step_for(60.0)
        assert _void(assessment, rig.run(_glance())) is None
    rig.step_for(VALID_FOR_S)
    assert _void(assessment, rig.run(_glance())) == Void(Disturbance.TOO_OLD)


@pytest.mark.parametrize(("act", "what"), [
    (lambda rig: rig.bench.module.activate(is_active=True), "Activation"),
    (lambda rig: rig.bench.set_charger(is_plugged_in=True), "Charging"),
    (lambda rig: rig.bench.set_cell(3.5), "Cell voltage"),
    (lambda rig: rig.bench.set_bay(is_open=True), "Light"),
    (lambda rig: rig.run(write_verified(BY_NAME["attitude_threshold"], 70)), "Attitude threshold"),
    (lambda rig: rig.run(write_verified(BY_NAME["freefall_trigger"], False)), "Free-fall trigger"),
    (lambda rig: rig.bench.change(mute_codes=frozenset({0x16}))
     or rig.run(write_verified(BY_NAME["attitude_trigger"], True)), "Attitude trigger"),
])  # fmt: skip
def test_what_changes_afterwards_voids_it(act: Callable[[Rig], object], what: str) -> None:
    rig = Rig()
    assessment = _go(rig)
    act(rig)
    void = _void(assessment, rig.run(_glance()))
    assert void is not None
    assert void.reason is Disturbance.CHANGED
    assert void.said.in_words() == f"the module changed: {what}"


def test_a_restart_a_silence_and_another_port_void_it() -> None:
    rig = Rig()
    assessment = _go(rig)
    sight = rig.run(_sight())
    assert void_reason(assessment, sight.device, sight.now, opened_at=None) == Void(Disturbance.DISCONNECTED)
    assert void_reason(assessment, sight.device, sight.now, opened_at=1.0) == Void(Disturbance.DISCONNECTED)
    rig.bench.change(mute=True)
    assert _void(assessment, rig.run(_heartbeat())) == Void(Disturbance.SILENT)
    rig.bench.heal()
    rig.bench.restart()
    rig.step_for(1.0)
    assert _void(assessment, rig.run(_glance())) == Void(Disturbance.RESTARTED)


def test_a_restart_that_nobody_heard_voids_it() -> None:
    rig = Rig()
    assessment = _go(rig)
    rig.bench.change(mute=True)
    rig.bench.restart()
    rig.step_for(0.5)
    rig.bench.heal()
    assert _void(assessment, rig.run(_glance())) == Void(Disturbance.RESTARTED)


@pytest.mark.parametrize("after_s", [0.0, 0.02, 0.2, 1.0, 2.5, 3.5])
def test_interrupted_it_is_void_and_no_go_with_what_was_seen(after_s: float) -> None:
    rig, evidence = Rig(), Evidence()
    run = Run(run_preflight(evidence, is_enabling=True))
    rig.session.run(run)
    rig.step_for(after_s)
    run.cancel()
    rig.step_until(lambda: run.is_done, limit_s=1.0)
    assert isinstance(run.error, Cancelled)
    assessment = _assessed(evidence)
    assert assessment.verdict is Verdict.NO_GO
    assert assessment.result("undisturbed") is Result.FAIL
    assert _void(assessment, rig.run(_sight())) == Void(Disturbance.INTERRUPTED)
    if after_s >= 1.0:
        assert evidence.values["attitude_threshold_deg"] == 60


@pytest.mark.parametrize("after_s", [0.01, 0.5, 2.5])
def test_unplugged_it_is_void_and_no_go(after_s: float) -> None:
    rig, evidence = Rig(), Evidence()
    run = Run(run_preflight(evidence, is_enabling=True))
    rig.session.run(run)
    rig.step_for(after_s)
    rig.bench.unplug()
    with pytest.raises(PortError):
        rig.step_for(5.0)
    rig.session.close()
    assert isinstance(run.error, PortLost)
    assessment = _assessed(evidence)
    assert assessment.verdict is Verdict.NO_GO
    assert evidence.disturbance is Disturbance.DISCONNECTED
    assert "undisturbed" in assessment.against


def test_an_active_module_gets_no_set_and_is_told_why() -> None:
    rig, evidence = Rig({"active": "yes"}), Evidence()
    rig.run(run_preflight(evidence, is_enabling=True))
    assert not [request for request in rig.line.requests if request.is_set]
    finding = next(one.finding for one in _assessed(evidence).checks if one.check.id == "attitude_trigger")
    assert "The module is ACTIVE" in finding.shown.in_words()


def test_no_evidence_at_all_is_no_go() -> None:
    assessment = _assessed(Evidence())
    assert assessment.verdict is Verdict.NO_GO
    assert {one.finding.result for one in assessment.checks} == {Result.UNKNOWN}
