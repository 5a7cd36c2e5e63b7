"""The check on the independent module: two on one line, one that contradicts itself, a line that repeats answers.

What is judged stands beside the module's own log and state; the module shares nothing with the product.
"""

import itertools

import pytest

from app.limits.past import Past
from app.modules.names import Remembered
from app.preflight.checks import Case, CheckResult, Person
from app.preflight.evidence import Evidence
from app.preflight.run import activate_ready
from app.preflight.verdict import Assessment, Verdict, assess
from app.procedures.write import WriteFault
from app.safety.journal import Act, Outcome
from app.settings.profiles import Profile
from app.text.messages import message
from protocol.catalogue import BY_NAME
from tests.module.options import Options
from tests.procedures.test_late_copies import ATTITUDE, FREEFALL, disabled
from tests.support.journals import FakeJournal
from tests.support.line.module_line import ModuleRig
from tests.support.records.preflight_rig import gather
from tests.support.thorough import some

SECOND_DELAYS_S = (0.0, 0.002, 0.02, 0.1, 0.3, 0.6, 0.9)
DIFFERENCES: tuple[dict[str, int], ...] = (
    {"boots": 12},
    {"attitude_threshold": 85},
    {"freefall_time": 90, "boots": 3},
    {"light_threshold": 40},
)


def case_of(evidence: Evidence) -> Case:
    person = Person(who="R. Tanaka", module="M-07", are_records_reviewed=True, are_settings_approved=True)
    past = Past(module="M-07", remembered=Remembered("M-07", boot_count=1), has_check=True, is_said_new=True)
    return Case(evidence=evidence, profile=Profile(settings={"light_threshold_v": 1.8}), past=past, person=person)


def check(rig: ModuleRig) -> tuple[Evidence, Assessment]:
    """With the triggers enabled; an interrupted one, too."""
    evidence = gather(rig, is_enabling=True)
    return evidence, assess(case_of(evidence))


def test_invalid_bytes_count_from_its_beginning_to_its_end() -> None:
    rig = ModuleRig().begin()
    rig.line.inject(bytes(5))
    rig.step_for(0.5)
    rig.line.inject(bytes(7), after_s=2.0)
    evidence, assessment = check(rig)
    assert evidence.rejected_bytes == 7
    assert assessment.result("link_loss") is CheckResult.FAIL


# Two on one line


def two_modules(delay_s: float, **settings: int) -> ModuleRig:
    """The second one stands at 80°, which fires, and answers so much later."""
    rig = ModuleRig(Options(delay_s=0.001), Options(delay_s=0.001 + delay_s))
    second = rig.modules[1]
    second.readings.tilt_deg = 80
    second.readings.boots = settings.pop("boots", 1)
    for name, value in settings.items():
        second.settings[BY_NAME[name].code] = value
    return rig


@pytest.mark.promise("f")
def test_a_line_with_a_second_talker_gets_no_verdict() -> None:
    for difference, delay_s in some(itertools.product(DIFFERENCES, SECOND_DELAYS_S), one_in=3):
        evidence, assessment = check(two_modules(delay_s, **difference))
        assert assessment.verdict is Verdict.NO_GO, (difference, delay_s)
        assert evidence.void is not None or assessment.result("read_twice") is not CheckResult.PASS


@pytest.mark.parametrize(("code", "text"), [(0x14, "01 1e"), (0x33, "01 01"), (0x34, "01 64"), (0x32, "50 0a 00 00")])
@pytest.mark.promise("f")
def test_a_second_answer_about_what_drifts_blocks_ready(code: int, text: str) -> None:
    for after_s in (0.001, 0.01, 0.1):
        _evidence, assessment = check(ModuleRig(Options(second={code: (after_s, text)})))
        assert assessment.verdict is Verdict.NO_GO, after_s


# Dialects


@pytest.mark.parametrize("options", [
    Options(acknowledged_by_one={0x21, 0x22}, voltage_code=0x34, freefall_code=0x17, empty_slot=0xFF),
    Options(voltage_code=0x35, freefall_code=0x16, record_gap_s=0.02, empty_slot=None),
    Options(delay_s=0.04, record_gap_s=0.02),
])  # fmt: skip
def test_every_dialect_of_a_sound_module_is_ready(options: Options) -> None:
    rig = disabled(ModuleRig(options))
    assert check(rig)[1].verdict is Verdict.READY
    assert (rig.module.settings[ATTITUDE], rig.module.settings[FREEFALL]) == (0, 0)
    assert [entry.code for entry in rig.module.log.sets()] == [FREEFALL, ATTITUDE]
    assert rig.module.log.acts() == []


def test_what_is_activated_and_not_reported_active_is_no_go() -> None:
    rig = ModuleRig()
    ready = check(rig)[1]
    rig.module.at_frame = lambda question: rig.module.options.instead.update({0x30: "01 00"} if question.is_set else {})
    performed, evidence = rig.run(activate_ready(ready, FakeJournal(), rig.permit(Act.ACTIVATE)))
    assert performed.outcome is Outcome.UNKNOWN
    assert assess(case_of(evidence)).verdict is Verdict.NO_GO


# Acknowledgements that come again (E4)


@pytest.mark.promise("f")
def test_a_line_that_repeats_an_acknowledgement_leaves_it_unknown() -> None:
    """What else may become of the two sets: `tests.procedures.test_late_copies`."""
    evidence, assessment = check(disabled(ModuleRig(Options(copies={ATTITUDE: [0.4], FREEFALL: [0.4]}))))
    assert assessment.verdict is Verdict.NO_GO
    assert {flag.why for flag in evidence.flags.values()} == {message(WriteFault.REPEATED.value)}
