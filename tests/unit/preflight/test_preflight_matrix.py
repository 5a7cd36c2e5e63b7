"""GO and READY only when everything holds: every single fault and every pair is named and hides none of the others."""

from dataclasses import replace

import pytest

from app.preflight.findings import CheckResult
from app.preflight.verdict import CHECKS, Verdict, assess, verdict_of
from app.records.record import read_document, sign
from app.records.verification import RecordState, StationNames, verify
from protocol.catalogue import BOOT_COUNT, CELL_VOLTAGE, Hazard
from protocol.stale_replies import TRIGGER_FLAGS
from tests.files.records.test_record import AT, PERSON
from tests.support.records.preflight_rig import FAULTS, Fault, assert_only_questions, check, gather, on_request
from tests.support.records.stations_made import station


def test_a_sound_module_is_ready() -> None:
    checked = check()
    assert checked.assessment.verdict is Verdict.READY
    assert checked.against == set()
    assert {one.finding.result for one in checked.assessment.checks} == {CheckResult.PASS}
    assert_only_questions(checked)
    sets = [request for request in checked.rig.line.requests if request.hazard is not Hazard.NONE]
    assert [request.command for request in sets] == list(TRIGGER_FLAGS)


@pytest.mark.parametrize("quirks", [
    {"ack": "one", "voltage_code": "34", "freefall_ack": "17", "empty_slots": "ones"},
    {"voltage_code": "35", "freefall_ack": "16", "records": "pieces", "split_ms": "4"},
    {"stream_at_boot": "yes", "rate": "500"},
    {"noise": "0.5", "delay_ms": "40", "jitter_ms": "20", "empty_slots": "zeros", "records": "spaced"},
])  # fmt: skip
def test_every_dialect_of_a_sound_module_goes(quirks: dict[str, str]) -> None:
    checked = check(options=quirks)
    assert checked.against == set()
    assert_only_questions(checked)


@pytest.mark.parametrize("name", FAULTS)
def test_each_single_fault_is_named_and_its_record_does_not_contradict_itself(name: str) -> None:
    fault = FAULTS[name]
    checked = check(fault)
    assert checked.assessment.verdict is Verdict.NO_GO
    assert fault.named <= checked.against
    assert [one.check for one in checked.assessment.checks] == list(CHECKS)
    assert_only_questions(checked, is_enabling=fault.is_enabling)
    signed = sign(checked.record({"at": AT}, **PERSON), station())
    assert verify(read_document(signed.text.encode()), StationNames(None)).state is RecordState.INTACT
    assert signed.record.follows is Verdict.NO_GO


def test_go_is_of_an_active_module_whose_triggers_were_enabled_before() -> None:
    enabled = check(options={"tilt": "0"})
    enabled.rig.bench.module.activate(is_active=True)
    before = len(enabled.rig.line.requests)
    evidence = gather(enabled.rig, is_enabling=True)
    assessment = assess(replace(enabled.assessment.case, evidence=evidence))
    assert (assessment.verdict, assessment.open_checks) == (Verdict.GO, ())
    # Nothing is written on an active module.
    assert not [request for request in enabled.rig.line.requests[before:] if request.hazard is not Hazard.NONE]


def test_a_locked_module_is_never_go_and_an_active_one_never_ready() -> None:
    assert verdict_of(is_fine=True, is_active=False) is Verdict.READY
    assert verdict_of(is_fine=True, is_active=True) is Verdict.GO
    for is_active in (False, True, None):
        assert verdict_of(is_fine=False, is_active=is_active) is Verdict.NO_GO
    assert verdict_of(is_fine=True, is_active=None) is Verdict.NO_GO


def test_light_that_reads_lower_is_judged_the_other_way() -> None:
    inverted = Fault(frozenset(), {"light_inverted": "yes"}, profile={"is_light_inverted": True})
    assert check(inverted).against == set()
    assert check(inverted, FAULTS["bay open"]).against == {"light"}


def test_nobody_there_is_all_unknown() -> None:
    checked = check(options={"mute": "yes"})
    assert checked.assessment.verdict is Verdict.NO_GO
    assert checked.against == {check.id for check in CHECKS} - {
        "guided_tests",
        "service",
    }  # what was done by hand before stands
    assert checked.rig.clock.now_s - 1000.0 < 12.0


def test_a_module_that_falls_silent_ends_the_check_at_once() -> None:
    checked = check(
        Fault(frozenset(), arrange=on_request(CELL_VOLTAGE.code, 1, lambda rig: rig.bench.change(mute=True)))
    )
    void = checked.assessment.case.evidence.void
    assert void is not None
    assert (void.word, void.message.in_english()) == ("silent", "The module was silent for a moment.")
    asked = [request.command for request in checked.rig.line.requests]
    rest = asked[asked.index(CELL_VOLTAGE) :]
    assert BOOT_COUNT in rest  # whether it is still there
    assert len(rest) <= 12


@pytest.mark.parametrize("number", range(1, 60, 8))
def test_a_restart_at_any_moment_never_goes_on_old_values(number: int) -> None:
    """A GO, where there is one, is of the module as it stands: the flags were set after its last start."""
    code = [request.command.code for request in check().rig.line.requests][number]
    for count in (1, 2, 12):
        checked = check(Fault(frozenset(), arrange=on_request(code, count, lambda rig: rig.bench.restart())))
        module = checked.rig.bench.module
        if checked.assessment.verdict is not Verdict.NO_GO:
            assert module.memory.boot_count == checked.assessment.case.evidence.values["boot_count"] == 37
        else:
            assert "connection" in checked.against
