"""Two modules on one line, and one that contradicts itself, by the independent module's own logs."""

import itertools
from typing import Any

import pytest

from app.engine.procedure import TwoModules
from app.limits.past import Past
from app.preflight.activation import activate_ready
from app.preflight.evidence import Disturbance, Evidence
from app.preflight.findings import Case, CheckResult, Person
from app.preflight.run import run_preflight
from app.preflight.verdict import Verdict, assess, void_reason
from app.procedures.act import Performed, perform
from app.procedures.read import read_everything
from app.procedures.settings_reading import read_one_module
from app.procedures.stream import StreamSwitch, watch
from app.procedures.write import WriteFault
from app.procedures.write_all import SettingChange, WriteContext, WriteReport, write_all
from app.safety.acts import REQUESTS, Act
from app.safety.interlocks import Interlock, Refusal
from app.safety.journal import Outcome
from app.settings.profiles import Profile
from protocol.catalogue import BY_NAME
from tests.module.options import Options
from tests.support.journals import FakeJournal
from tests.support.line.module_line import ModuleRig
from tests.support.thorough import some

ACTIVATION = 0x10
SECOND_DELAYS_S = (0.0, 0.002, 0.02, 0.1, 0.3, 0.6, 0.9)


def two_modules(delay_s: float, **settings: int) -> ModuleRig:
    """The second one stands at 80°, which fires, and answers so much later."""
    rig = ModuleRig(Options(delay_s=0.001), Options(delay_s=0.001 + delay_s))
    second = rig.modules[1]
    second.readings.tilt_deg = settings.pop("tilt_deg", 80)
    second.readings.boots = settings.pop("boots", 1)
    for name, value in settings.items():
        second.settings[BY_NAME[name].code] = value
    return rig


DIFFERENCES: tuple[dict[str, int], ...] = (
    {"boots": 12},
    {"attitude_threshold": 85},
    {"freefall_time": 90, "boots": 3},
    {"light_threshold": 40},
    {},  # all the same but the tilt
)


def activate(rig: ModuleRig) -> Performed:
    """As `dps-s activate` does."""
    reading = rig.run(read_one_module())
    if isinstance(reading, Refusal):
        return Performed(act=Act.ACTIVATE, outcome=Outcome.NOT_SENT, refusals=(reading,))
    return rig.run(perform(Act.ACTIVATE, FakeJournal(), permit=rig.permit(Act.ACTIVATE)))


@pytest.mark.parametrize("difference", DIFFERENCES, ids=str)
@pytest.mark.promise("f")
def test_activating_makes_neither_of_them_active(difference: dict[str, int]) -> None:
    for delay_s in SECOND_DELAYS_S:
        for is_second_first in (False, True):
            rig = two_modules(delay_s, **difference)
            if is_second_first:
                rig.modules.reverse()
                rig.line.modules = tuple(rig.modules)
            for _ in range(2):
                done = activate(rig)
                assert done.outcome is Outcome.NOT_SENT, (delay_s, done)
            assert [module.settings[ACTIVATION] for module in rig.modules] == [0, 0]
            assert all(module.log.acts() == [] for module in rig.modules)


def test_in_the_window_too_where_everything_is_read_all_the_time() -> None:
    for difference, delay_s in some(itertools.product(DIFFERENCES, SECOND_DELAYS_S), one_in=4):
        rig = two_modules(delay_s, **difference)
        rig.session.run_in_background(watch(StreamSwitch(is_wanted=False)))
        rig.step_for(3.0)
        done = rig.run(perform(Act.ACTIVATE, FakeJournal(), permit=rig.permit(Act.ACTIVATE)))
        assert done.outcome is Outcome.NOT_SENT
        assert [module.settings[ACTIVATION] for module in rig.modules] == [0, 0]


@pytest.mark.parametrize("act", [Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY])
def test_no_other_act_reaches_them(act: Act) -> None:
    rig = two_modules(0.002, attitude_threshold=85, tilt_deg=2)
    done = rig.run(perform(act, FakeJournal(), permit=rig.permit(act)))
    assert done.outcome is Outcome.NOT_SENT
    assert "Two modules on this line?" in done.sentence
    assert all(module.log.acts() == [] for module in rig.modules)


@pytest.mark.promise("f")
def test_the_permit_is_void_after_a_contradiction() -> None:
    rig = two_modules(0.002, attitude_threshold=85)
    permit = rig.permit(Act.ACTIVATE)
    with pytest.raises(TwoModules, match=r"Attitude threshold: 60°, then 85°\. Two modules on this line"):
        rig.run(read_everything())
    rig.line.modules = (rig.module,)  # the second one was unplugged
    rig.step_for(6.0)
    done = rig.run(perform(Act.ACTIVATE, FakeJournal(), permit=permit))
    assert [refusal.condition for refusal in done.refusals] == [Interlock.CONFIRMED]
    again = rig.run(perform(Act.ACTIVATE, FakeJournal(), permit=rig.permit(Act.ACTIVATE)))
    assert again.outcome is Outcome.CONFIRMED


def case_of(evidence: Evidence) -> Case:
    person = Person(who="R. Tanaka", module="M-07", are_records_reviewed=True, are_settings_approved=True)
    past = Past(module="M-07", boot_count=1, has_check=True, is_said_new=True)
    return Case(evidence=evidence, profile=Profile(settings={"light_threshold_v": 1.8}), past=past, person=person)


def check(rig: ModuleRig) -> tuple[Evidence, Any]:
    evidence = Evidence(port="sim")
    rig.run(run_preflight(evidence, is_enabling=True, journal=FakeJournal()))
    return evidence, assess(case_of(evidence))


def test_a_check_of_two_is_no_go_and_says_why() -> None:
    for difference, delay_s in some(itertools.product(DIFFERENCES[:-1], SECOND_DELAYS_S), one_in=3):
        evidence, assessment = check(two_modules(delay_s, **difference))
        assert assessment.verdict is Verdict.NO_GO, (difference, delay_s)
        assert evidence.disturbance is not None


def test_a_second_answer_to_each_question_about_a_threshold_ends_the_check() -> None:
    """First 60°, and 2 ms later the truth."""
    rig = ModuleRig(Options(second={0x20: (0.002, "01 55"), 0x22: (0.002, "01 5a"), 0x21: (0.002, "01 03")}))
    evidence, assessment = check(rig)
    assert assessment.verdict is Verdict.NO_GO
    assert evidence.disturbance is Disturbance.CONTRADICTED
    undisturbed = next(one for one in assessment.checks if one.check.id == "undisturbed")
    assert undisturbed.finding.shown.in_english() == "Attitude threshold: 60°, then 85°. Two modules on this line?"


@pytest.mark.parametrize(
    ("code", "text"), [(0x14, "01 1e"), (0x33, "01 01"), (0x34, "01 64"), (0x32, "50 0a 00 00"), (0x30, "01 01")]
)
@pytest.mark.promise("f")
def test_a_second_answer_about_what_drifts_blocks_ready(code: int, text: str) -> None:
    for after_s in (0.001, 0.01, 0.1):
        _evidence, assessment = check(ModuleRig(Options(second={code: (after_s, text)})))
        assert assessment.verdict is Verdict.NO_GO, after_s


@pytest.mark.promise("f")
def test_a_verdict_is_void_when_a_second_module_answers() -> None:
    rig = ModuleRig()
    _evidence, ready = check(rig)
    assert ready.verdict is Verdict.READY
    rig.module.options.second = {0x20: (0.002, "01 55")}
    with pytest.raises(TwoModules):
        rig.run(read_everything())
    now = rig.clock()
    void = void_reason(ready, rig.session.device.view(now), now, opened_at=rig.session.opened_at)
    assert void is not None
    assert void.message.in_english() == (
        "contradictory answers: Attitude threshold: 60°, then 85°. Two modules on this line?"
    )
    performed, after = rig.run(activate_ready(ready, FakeJournal(), rig.permit(Act.ACTIVATE)))
    assert performed.outcome is Outcome.NOT_SENT
    assert after.disturbance is Disturbance.CONTRADICTED
    assert rig.module.log.acts() == []


# Writing


def write(
    rig: ModuleRig, journal: FakeJournal | None = None, *, is_unlocked: bool = False, **values: float
) -> WriteReport:
    changes = [SettingChange(BY_NAME[name], value) for name, value in values.items()]
    accepted = frozenset(changes)
    context = WriteContext(journal=journal or FakeJournal(), is_unlocked=is_unlocked, accepted_risks=accepted)
    return rig.run(write_all(changes, context))


def test_what_is_written_to_two_is_not_verified() -> None:
    for difference, delay_s in some(itertools.product(DIFFERENCES[:-1], SECOND_DELAYS_S), one_in=3):
        rig, journal = two_modules(delay_s, **difference), FakeJournal()
        report = write(rig, journal, freefall_acceleration=0.4)
        assert not report.is_fine, (difference, delay_s)
        assert not any(written.verified for written in report.results)
        assert Outcome.CONFIRMED not in journal.outcomes.values()


@pytest.mark.promise("f")
def test_a_second_module_in_the_middle_takes_back_what_was_verified() -> None:
    for number in range(1, 30, 4):
        rig, journal, frames = ModuleRig(), FakeJournal(), itertools.count()

        def plug_in(_question: object, rig: ModuleRig = rig, frames: Any = frames, number: int = number) -> None:
            if next(frames) == number:
                rig.module.options.second = {0x15: (0.002, "01 40")}

        rig.module.at_frame = plug_in
        report = write(rig, journal, freefall_acceleration=0.4, freefall_time=1.2)
        assert not report.is_fine, number
        assert not any(written.verified for written in report.results)
        sent = {entry.code for entry in rig.module.log.sets()}
        for written in report.results:
            expected = WriteFault.CONTRADICTED if written.command.code in sent else WriteFault.NOT_ALLOWED
            assert written.fault is expected, number
        assert all(outcome is not Outcome.CONFIRMED for outcome in journal.outcomes.values())


@pytest.mark.parametrize("after_s", [0.02, 0.5, 0.8, 0.95])
@pytest.mark.parametrize("count", [1, 4])
@pytest.mark.promise("f")
def test_a_setting_that_reverts_soon_after_it_was_verified_is_not(after_s: float, count: int) -> None:
    values = {"freefall_acceleration": 0.4, "freefall_time": 1.2, "light_threshold": 2.0, "attitude_threshold": 65}
    wanted: dict[str, Any] = dict([*values.items()][:count])
    reverting = BY_NAME["attitude_threshold" if count == 4 else "freefall_acceleration"]
    rig = ModuleRig(Options(reverts={reverting.code: (after_s, None)}))
    report = write(rig, **wanted)
    said = {written.command: written for written in report.results}
    assert not said[reverting].verified
    assert said[reverting].fault is not None
    assert all(written.verified for command, written in said.items() if command is not reverting)


def test_the_last_reading_comes_a_second_after_the_last_write() -> None:
    rig = ModuleRig()
    assert write(rig, freefall_acceleration=0.4, freefall_time=1.2).is_fine
    last_set = rig.module.log.sets()[-1]
    last = [entry for entry in rig.module.log.got(last_set.code) if not entry.is_set][-2:]
    assert all(entry.at_s - last_set.at_s >= 1.0 for entry in last)


# 30 and 31


LIES: tuple[tuple[dict[int, str], int, str], ...] = (
    ({0x30: "01 01"}, 0, "active"),
    ({0x30: "01 00"}, 1, "active"),
    ({0x31: "01 01"}, 0, "triggered"),
)


@pytest.mark.parametrize(("instead", "is_active", "key"), LIES)
@pytest.mark.promise("h")
def test_a_status_that_30_or_31_contradicts_is_no_pass(instead: dict[int, str], is_active: int, key: str) -> None:
    rig = ModuleRig(Options(instead=instead))
    rig.module.settings[ACTIVATION] = is_active
    evidence, assessment = check(rig)
    assert assessment.verdict is Verdict.NO_GO
    found = assessment.result("activation" if key == "active" else "triggered")
    assert found is CheckResult.UNKNOWN
    said = evidence.said_otherwise(key)
    assert said is not None
    assert said.in_english().startswith("30: " if key == "active" else "31: ")
    everything = rig.run(read_everything())
    assert list(everything.contradictions) == [key]


@pytest.mark.parametrize("code", [0x30, 0x31])
def test_a_module_that_does_not_answer_one_of_them_is_not_ready(code: int) -> None:
    _evidence, assessment = check(ModuleRig(Options(lost_queries={code: -1})))
    assert assessment.verdict is Verdict.NO_GO


@pytest.mark.parametrize(
    "options",
    [*(Options(instead=instead) for instead, is_active, _key in LIES if not is_active),
     Options(lost_queries={0x30: -1}), Options(lost_queries={0x31: -1})],
)  # fmt: skip
@pytest.mark.promise("h")
def test_nothing_is_written_and_nothing_done_then(options: Options) -> None:
    rig = ModuleRig(options)
    report = write(rig, freefall_time=1.2)
    assert report.is_refused
    assert report.refusals[0].sentence[:3] in ("30:", "31:")
    for act in (Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN):
        done = rig.run(perform(act, FakeJournal(), permit=rig.permit(act)))
        assert done.outcome is Outcome.NOT_SENT
    assert rig.module.log.sets() == rig.module.log.acts() == []
    assert write(rig, is_unlocked=True, freefall_time=1.2).results[0].verified, "a person unlocked it"


def test_after_activating_30_has_to_agree_too() -> None:
    rig = ModuleRig()
    ready = check(rig)[1]
    assert ready.verdict is Verdict.READY
    rig.module.at_frame = lambda question: (
        rig.module.options.instead.update({0x30: "01 00"}) if question.is_set else None
    )
    performed, evidence = rig.run(activate_ready(ready, FakeJournal(), rig.permit(Act.ACTIVATE)))
    assert rig.module.settings[ACTIVATION] == 1
    assert performed.outcome is Outcome.UNKNOWN
    assert assess(case_of(evidence)).verdict is Verdict.NO_GO


@pytest.mark.parametrize(("act", "request_"), [(Act.ACTIVATE, REQUESTS[Act.ACTIVATE]), (None, None)])
@pytest.mark.promise("h")
def test_directly_before_a_frame_who_is_there_is_asked_the_boot_count_last(act: Act | None, request_: Any) -> None:
    rig = ModuleRig()
    if act is None:
        write(rig, freefall_time=1.2)
    else:
        assert rig.run(perform(act, FakeJournal(), permit=rig.permit(act))).outcome is Outcome.CONFIRMED
    entries = rig.module.log.got()
    at = next(number for number, entry in enumerate(entries) if entry.is_set)
    assert [entry.code for entry in entries[at - 4 : at]] == [0x30, 0x31, 0x32, 0x23]
    assert entries[at].at_s - entries[at - 1].at_s < 0.1
