"""The limits of the checks of settings, triggers and identity."""

from collections import Counter
from dataclasses import replace
from typing import Any

import pytest

from app.engine.conversation import StatusSample
from app.guided.results import GuidedKind, GuidedVerdict, StoredTest
from app.limits.limits import SETTING_BOUNDS
from app.limits.past import LastAnswer, LastTested, Past
from app.modules.names import Remembered
from app.modules.service import DueService
from app.preflight.evidence import CANCELLED, FIRED, OVER, TOO_OLD, UNFINISHED, UNREAD, Evidence, TriggerFlag
from app.preflight.findings import CHECK_LINK, Case, CheckResult, Finding, Person
from app.preflight.module_checks import RecordsWord, guided_tests, records_word, service, settings_fingerprint
from app.preflight.verdict import CHECKS
from app.procedures.history import History
from app.settings.profiles import NO_PROFILE, Profile
from app.text.messages import UserMessage
from protocol.fields import Value
from protocol.messages import TriggerRecord, decode
from tests.support.line.link_bench import RECORD
from tests.support.records.preflight_rig import check

PASS, FAIL, WARN, UNKNOWN = CheckResult.PASS, CheckResult.FAIL, CheckResult.WARN, CheckResult.UNKNOWN


def finding(
    check_id: str, *, past: Past | None = None, settings: dict[str, Value] | None = None, is_same: bool = False,
    is_reviewed: bool = False, **evidence: Any,
) -> Finding:  # fmt: skip
    case = Case(
        evidence=Evidence(port="sim", **evidence), profile=Profile(settings=settings or {}),
        past=past or Past(), person=Person(are_records_reviewed=is_reviewed, is_same_module=is_same),
    )  # fmt: skip
    return next(check for check in CHECKS if check.id == check_id).judge(case)


def test_a_setting_is_judged_by_the_advice_at_both_ends() -> None:
    for key, bound in SETTING_BOUNDS.items():
        step = 1 if key == "attitude_threshold_deg" else 0.01 if key == "freefall_time_s" else 0.1
        fine = WARN if key == "light_threshold_v" else PASS
        results = [(bound.advised_low, fine), (bound.advised_high, fine), (bound.advised_low - step, FAIL)]
        if key != "light_threshold_v" and key != "freefall_time_s":  # of which no byte is higher
            results.append((bound.advised_high + step, FAIL))
        for value, result in results:
            assert finding(bound.check, values={key: round(value, 2)}).result is result, (key, value)
        assert finding(bound.check).result is UNKNOWN


@pytest.mark.parametrize(("value", "result"), [(40, PASS), (41, FAIL), (60, FAIL), (None, UNKNOWN)])
def test_a_setting_of_the_profile_is_judged_by_its_value(value: int | None, result: CheckResult) -> None:
    found = finding(
        "attitude_threshold",
        settings={"attitude_threshold_deg": 40},
        values={} if value is None else {"attitude_threshold_deg": value},
    )
    assert (found.result, found.limit.in_english()) == (result, "= 40°")


@pytest.mark.promise("f")
def test_a_setting_beyond_the_bounds_fails_even_where_the_profile_wants_it() -> None:
    for key, bound in SETTING_BOUNDS.items():
        step = {"attitude_threshold_deg": 1, "freefall_time_s": 0.01}.get(key, 0.1)
        for value, is_beyond in ((bound.low - step, True), (bound.low, False), (bound.high, False)):
            wanted: dict[str, Value] = {key: round(value, 2)}
            assert (finding(bound.check, settings=wanted, values=wanted).result is FAIL) is is_beyond, wanted
    for key, value in (("attitude_threshold_deg", 91), ("freefall_acceleration_g", 0.9)):
        assert finding(SETTING_BOUNDS[key].check, settings={key: value}, values={key: value}).result is FAIL


@pytest.mark.parametrize(
    ("flag", "result", "shown"),
    [
        (TriggerFlag(True), PASS, "enabled"),
        (TriggerFlag(False), FAIL, "DISABLED"),
        (TriggerFlag(why=UserMessage("why")), UNKNOWN, "why"),
        (TriggerFlag(), UNKNOWN, "not enabled in this conversation"),
        (None, UNKNOWN, "not asked"),
    ],
)
def test_a_trigger_is_enabled_only_where_that_is_known(
    flag: TriggerFlag | None, result: CheckResult, shown: str
) -> None:
    flags = {} if flag is None else {"attitude_trigger": flag}
    for is_active in (False, True):
        found = finding("attitude_trigger", flags=flags, status=StatusSample(0.0, 0, 1.0, False, is_active))
        assert (found.result, found.shown.in_english()) == (result, shown)
        assert found.measured is (None if flag is None else flag.is_enabled)
        is_to_lock = is_active and flag is not None and flag.is_enabled is None
        assert (found.do not in (None, CHECK_LINK)) is is_to_lock


@pytest.mark.parametrize(
    ("before", "count", "more", "result", "shown"),
    [
        (7, 7, {}, PASS, "7"),
        (7, 135, {}, PASS, "135"),
        (7, 136, {}, FAIL, "136: another module?"),
        (7, 6, {}, FAIL, "6: another module?"),
        (7, 6, {"is_same": True}, PASS, "6, confirmed by a person"),
        (255, 0, {}, PASS, "0"),
        (None, 7, {}, WARN, "7: no earlier visit"),
        (7, None, {}, UNKNOWN, "not asked"),
    ],
)
def test_a_boot_count_only_grows(
    before: int | None, count: int | None, more: dict[str, Any], result: CheckResult, shown: str
) -> None:
    values = {} if count is None else {"boot_count": count}
    past = Past(module="M-07", remembered=Remembered("M-07", boot_count=before))
    found = finding("boot_count", past=past, values=values, **more)
    assert (found.result, found.shown.in_english()) == (result, shown)
    assert found.limit.in_english().startswith("≥ last visit; " if before is None else f"≥ {before}; ")
    other_records = finding("boot_count", past=replace(past, do_records_follow=False), values=values, **more)
    assert other_records.result is (FAIL if result is PASS and not more else result)
    is_why = other_records.shown.in_english().endswith("other trigger records, another module?")
    assert is_why is (result is PASS and not more)
    nameless = finding("boot_count", values=values)
    assert nameless.result is (UNKNOWN if count is None else WARN)
    assert count is None or (nameless.do is not None and nameless.do.in_english() == "Name the module.")


@pytest.mark.parametrize("approved", ["CODE", None])
@pytest.mark.parametrize("is_approved", [False, True])
def test_settings_that_were_not_approved_pass_only_by_a_persons_word(is_approved: bool, approved: str | None) -> None:
    case = check().assessment.case
    other = replace(case, profile=case.profile._replace(approved_fingerprint=approved), past=Past(),
                    person=replace(case.person, are_settings_approved=is_approved))  # fmt: skip
    found = settings_fingerprint(other)
    assert found.result is (PASS if is_approved else FAIL if approved else WARN)
    assert ("confirmed by a person" in found.shown.in_english()) is is_approved


def record() -> TriggerRecord:
    found = decode(RECORD)
    assert isinstance(found, TriggerRecord)
    return found


RECORDED, LAST, LOST = record(), LastAnswer("2026-11-02T10:00:00+00:00", 3), UserMessage("no reply")


@pytest.mark.parametrize(
    ("history", "past", "is_reviewed", "result", "shown"),
    [
        (None, Past(), False, UNKNOWN, "not asked"),
        (History(), Past(), False, UNKNOWN, "no reply"),
        (History(), Past(), True, WARN, "no reply: new, no records"),
        (History(), Past(is_said_new=True), False, WARN, "no reply: new, no records"),
        (History(), Past(last_answer=LAST, is_said_new=True), True, FAIL, "no reply; had 3 on 2026-11-02"),
        (History(is_answered=True, is_confirmed=True), Past(), False, PASS, "0 of 0 not reviewed"),
        (History(is_answered=True), Past(), False, UNKNOWN, "readings differ"),
        (History((RECORDED,), is_answered=True, is_confirmed=True), Past(), False, UNKNOWN, "1 of 1 not reviewed"),
        (History((RECORDED,), is_answered=True, is_confirmed=True), Past(has_check=True), False, FAIL,
         "1 of 1 not reviewed"),
        (History((RECORDED,), is_answered=True, is_confirmed=True), Past(has_check=True), True, PASS,
         "all records reviewed, confirmed by a person"),
        (History((RECORDED,), is_answered=True, is_confirmed=True),
         Past(has_check=True, reviewed=Counter([RECORD])), False, PASS, "0 of 1 not reviewed"),
        (History((RECORDED, RECORDED), is_answered=True, is_confirmed=True),
         Past(has_check=True, reviewed=Counter([RECORD])), False, FAIL, "1 of 2 not reviewed"),
    ],
)  # fmt: skip
def test_a_new_record_is_judged_by_a_person(
    history: History | None, past: Past, is_reviewed: bool, result: CheckResult, shown: str
) -> None:
    found = finding("trigger_records", past=past, is_reviewed=is_reviewed, history=history)
    assert (found.result, found.shown.in_english()) == (result, shown)


def test_silence_counts_as_new_only_while_everything_else_is_answered_and_nothing_was_triggered() -> None:
    past = Past(is_said_new=True)
    lost = finding("trigger_records", past=past, is_reviewed=True, history=History(), faults={"light_v": LOST})
    assert (lost.result, lost.shown.in_english()) == (UNKNOWN, "no reply")
    for void in (CANCELLED, FIRED, OVER, TOO_OLD, UNFINISHED, UNREAD):
        found = finding("trigger_records", past=past, is_reviewed=True, history=History(), void=void)
        assert found.result is UNKNOWN
    fired = finding("trigger_records", past=past, is_reviewed=True, history=History(),
                    reports=[StatusSample(0.0, 0, 10, triggered=True, active=False)])  # fmt: skip
    assert (fired.result, fired.shown.in_english()) == (FAIL, "no reply: triggered")


@pytest.mark.parametrize("is_reviewed", [False, True])
@pytest.mark.promise("f")
def test_a_module_that_may_have_fired_before_it_restarted_is_not_ready_while_the_notice_is_open(
    is_reviewed: bool,
) -> None:
    for history in (History(is_answered=True, is_confirmed=True), History()):
        found = finding("trigger_records", is_reviewed=is_reviewed, history=history, may_have_fired=True)
        assert (found.result, found.shown.in_english()) == (UNKNOWN, "may have fired before the restart")


@pytest.mark.parametrize(
    ("history", "past", "word"),
    [
        (None, Past(), None),
        (History(), Past(), RecordsWord.NEW_MODULE),
        (History(), Past(is_said_new=True), None),
        (History(), Past(last_answer=LAST), None),
        (History(is_answered=True), Past(), None),
        (History(is_answered=True, is_confirmed=True), Past(), None),
        (History((RECORDED,), is_answered=True), Past(), None),
        (History((RECORDED,), is_answered=True, is_confirmed=True), Past(), RecordsWord.REVIEWED),
        (History((RECORDED,), is_answered=True, is_confirmed=True), Past(reviewed=Counter([RECORD])), None),
    ],
)
@pytest.mark.parametrize("is_said", [False, True])
def test_a_word_is_offered_only_where_it_settles_something(
    history: History | None, past: Past, word: RecordsWord | None, is_said: bool
) -> None:
    evidence = Evidence(history=history)
    case = Case(evidence=evidence, profile=NO_PROFILE, past=past, person=Person(are_records_reviewed=is_said))
    assert records_word(case) is word


def guided(
    within_days: dict[GuidedKind, int], tests: dict[GuidedKind, LastTested], module: str | None = "M-07"
) -> Finding:
    past = Past(module=module, tests=tests)
    profile = Profile(tests_within_days=within_days)
    return guided_tests(Case(evidence=Evidence(), profile=profile, past=past))


def last(verdict: GuidedVerdict, age_days: float | None) -> LastTested:
    return LastTested(StoredTest(kind=GuidedKind.TILT, verdict=verdict, at="2026-01-01", who="Li"), age_days)


@pytest.mark.parametrize(
    ("found_last", "result", "shown"),
    [
        (last(GuidedVerdict.PASSED, 30.0), PASS, "Attitude trigger: passed (30 d)"),
        (last(GuidedVerdict.PASSED, 30.5), FAIL, "Attitude trigger: passed (30 d)"),
        (last(GuidedVerdict.PASSED, None), FAIL, "Attitude trigger: passed (? d)"),
        (last(GuidedVerdict.FAILED, 1.0), FAIL, "Attitude trigger: FAILED (1 d)"),
        (last(GuidedVerdict.UNCLEAR, 1.0), FAIL, "Attitude trigger: unclear (1 d)"),
        (None, FAIL, "Attitude trigger: not tested"),
    ],
)
@pytest.mark.promise("f")
def test_a_demanded_test_that_is_missing_failed_or_too_old_fails_the_check(
    found_last: LastTested | None, result: CheckResult, shown: str
) -> None:
    tests = {} if found_last is None else {GuidedKind.TILT: found_last}
    found = guided({GuidedKind.TILT: 30}, tests)
    assert (found.result, found.shown.in_english()) == (result, shown)
    assert found.measured == int(result is FAIL)
    assert found.limit.in_english().startswith("Attitude trigger within 30 days; ")
    assert guided({GuidedKind.TILT: 30}, tests, None).result is UNKNOWN
    assert guided({GuidedKind.BAY: 30}, tests).result is FAIL, "a test of something else"


def test_without_a_demand_only_a_failed_test_is_a_warning() -> None:
    passed, failed = last(GuidedVerdict.PASSED, 2.0), last(GuidedVerdict.FAILED, 3.0)
    for found, result, shown in (
        (guided({}, {}), PASS, "none"),
        (guided({}, {GuidedKind.BAY: passed}), PASS, "Parachute bay: passed (2 d)"),
        (guided({}, {GuidedKind.TILT: last(GuidedVerdict.PASSED, 400.0)}), PASS, "Attitude trigger: passed (400 d)"),
        (guided({}, {GuidedKind.BAY: passed, GuidedKind.TILT: failed}), WARN, "Attitude trigger: FAILED (3 d)"),
        (guided({}, {}, None), PASS, "none"),
    ):
        assert (found.result, found.shown.in_english()) == (result, shown)
        assert found.limit.in_english().startswith("none; ")


@pytest.mark.parametrize(("name", "is_by_option", "known"), [
    ("M-07", False, "M-07, named by a person in this conversation"),
    ("M-07", True, "M-07, given by --module"),
    (None, False, "module not named"),
])  # fmt: skip
@pytest.mark.promise("a")
def test_what_is_kept_under_a_name_is_used_with_the_words_by_what_the_module_is_known(
    name: str | None, is_by_option: bool, known: str
) -> None:
    case = Case(
        evidence=Evidence(port="sim"), profile=NO_PROFILE, past=Past(module=name, fingerprint=name and "CODE"),
        person=Person(is_named_by_option=is_by_option),
    )  # fmt: skip
    limits = {check.id: check.judge(case).limit.in_english() for check in CHECKS}
    said = {id_: limit for id_, limit in limits.items() if limit.endswith(f"; {known}")}
    assert said.keys() == {"trigger_records", "boot_count", "fingerprint", "guided_tests", "service"}
    approved = replace(case, profile=Profile(approved_fingerprint="CODE"))
    assert settings_fingerprint(approved).limit.in_english() == "CODE"  # by the profile, under no name


SOON, LATE = DueService(UserMessage("Repack due"), False), DueService(UserMessage("Cell overdue"), True)


@pytest.mark.parametrize(
    ("due", "result", "required"),
    [([], PASS, PASS), ([SOON], WARN, WARN), ([LATE], WARN, FAIL), ([SOON, LATE], WARN, FAIL)],
)
def test_what_is_overdue_is_a_warning_or_not_met_as_the_profile_says(
    due: list[DueService], result: CheckResult, required: CheckResult
) -> None:
    past = Past(module="M-07", due=due)
    for is_required, expected in ((False, result), (True, required)):
        profile = Profile(is_service_required=is_required)
        found = service(Case(evidence=Evidence(), profile=profile, past=past))
        assert found.result is expected
        assert found.shown.in_english() == (" ".join(one.text.in_english() for one in due) or "none")
    unnamed = Case(evidence=Evidence(), profile=profile, past=Past())
    assert service(unnamed).result is UNKNOWN
