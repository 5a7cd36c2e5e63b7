"""Each check alone: what is exactly at its limit passes, one step beyond does not, and what is not known says why."""

from collections import Counter
from dataclasses import replace
from functools import partial
from typing import Any

import pytest

from app.engine.conversation import Interrupted, StatusSample
from app.guided.results import GuidedKind, GuidedVerdict, StoredTest
from app.limits.limits import SETTING_BOUNDS
from app.limits.past import LastTested, Past
from app.modules.names import Remembered
from app.modules.service import DueService
from app.preflight import evidence
from app.preflight.checks import CHECKS, REPORTS_NEEDED, Case, CheckResult, Finding, Person, RecordsWord
from app.preflight.evidence import (
    CANCELLED,
    CHECK_AGAIN,
    CHECK_LINK,
    FIND_OUT_WHY,
    STILL_S,
    UNFINISHED,
    Evidence,
    StateReading,
    TriggerFlag,
    void_of_end,
)
from app.procedures.history import History
from app.procedures.read import Present, Readings
from app.settings.profiles import NO_PROFILE, Profile
from app.store.fact_store import Kept
from app.store.rows import ModuleVisited, Row
from app.text.messages import UserMessage
from protocol.catalogue import BY_NAME
from protocol.events import EndReason, Unanswered
from protocol.fields import Value
from protocol.messages import TriggerRecord, decode
from tests.unit.protocol.link_bench import RECORD

PASS, FAIL, WARN, UNKNOWN = CheckResult.PASS, CheckResult.FAIL, CheckResult.WARN, CheckResult.UNKNOWN
TILT = "attitude_threshold_deg"
SILENT = void_of_end(Interrupted(EndReason.SILENT))
seen = partial(StatusSample, 0.0)
LEVEL, FIRED, ACTIVE = seen(0, 1.0, False, False), seen(0, 1.0, True, False), seen(0, 1.0, False, True)


def finding(
    check_id: str,
    *,
    profile: Profile = NO_PROFILE,
    past: Past | None = None,
    person: Person | None = None,
    **evidence: Any,
) -> Finding:
    case = Case(
        evidence=Evidence(port="sim", **evidence), profile=profile, past=past or Past(), person=person or Person()
    )
    return next(check for check in CHECKS if check.id == check_id).judge(case)


def still(*statuses: StatusSample, count: int = REPORTS_NEEDED, lasting_s: float = STILL_S) -> list[StatusSample]:
    filled = [*statuses, *[LEVEL] * (count - len(statuses))]
    return [status._replace(at=lasting_s * number / (count - 1)) for number, status in enumerate(filled)]


def beats(sent: int, lost: int, invalid: int = 0) -> dict[str, Any]:
    return {"heartbeats_sent": sent, "heartbeats_lost": lost, "rejected_bytes": invalid}


def cell(*volts: float, charging: tuple[bool, ...] = (False, False)) -> dict[str, Any]:
    return {"series": {"cell_voltage_v": list(volts), "charging": list(charging)}}


def light(*volts: float, threshold: float | None = 2.0) -> dict[str, Any]:
    values = {} if threshold is None else {"light_threshold_v": threshold}
    return {"series": {"light_v": list(volts)}, "values": values}


def reading(present: Present | None = None, *, is_counted: bool = True, unread: tuple[str, ...] = ()) -> StateReading:
    settings = Readings()
    settings.values = {"freefall_time_s": 1.6} | ({"boot_count": 7} if is_counted else {})
    silent = [*unread, *([] if is_counted else ["boot_count"])]
    settings.errors = {BY_NAME[name].key: Unanswered(BY_NAME[name].query(), 6, 1.0, 0.0) for name in silent}
    return StateReading(settings, (present or Present(False, False, LEVEL))._replace(is_counted=is_counted))


CASES: tuple[tuple[str, dict[str, Any], CheckResult, str], ...] = (
    ("link_loss", beats(20, 0), PASS, "0 of 20 lost, invalid bytes: 0"),
    ("link_loss", beats(20, 1), FAIL, "1 of 20 lost, invalid bytes: 0"),
    ("link_loss", beats(20, 0, 1), FAIL, "0 of 20 lost, invalid bytes: 1"),
    ("link_loss", beats(19, 0), FAIL, "0 of 19 lost, invalid bytes: 0"),
    ("link_loss", {}, UNKNOWN, "not asked"),
    ("round_trip", {"round_trips_s": [0.02, 0.1, 0.01, 0.04]}, PASS, "100.0 ms, median 40.0 ms"),
    ("round_trip", {"round_trips_s": [0.02, 0.1001, 0.01, 0.04]}, FAIL, "100.1 ms, median 40.0 ms"),
    ("tilt", {"reports": still(seen(5, 1.0, False, False))}, PASS, "5°"),
    ("tilt", {"reports": still(seen(6, 1.0, False, False))}, FAIL, "6°"),
    ("tilt_spread", {"reports": still(seen(3, 1.0, False, False))}, FAIL, "3°"),
    ("acceleration", {"reports": still(seen(0, 0.9, False, False))}, PASS, "0.9 g"),
    ("acceleration", {"reports": still(seen(0, 1.2, False, False))}, FAIL, "1.2 g"),
    ("acceleration_spread", {"reports": still(seen(0, 0.9, False, False), seen(0, 1.1, False, False))}, PASS, "0.2 g"),
    ("acceleration_spread", {"reports": still(seen(0, 0.9, False, False), seen(0, 1.2, False, False))}, FAIL, "0.3 g"),
    ("tilt", {"reports": still(count=14)}, UNKNOWN, "reports in 2 s: only 14"),
    ("acceleration_spread", {"reports": still(lasting_s=1.4375)}, UNKNOWN, "reports in 2 s: only 15"),
    ("cell_voltage", cell(3.8, 4.0), PASS, "3.80 V"),
    ("cell_voltage", cell(4.0, 3.78), FAIL, "3.78 V"),
    ("cell_voltage", cell(4.0, 4.24), PASS, "4.00 V"),
    ("cell_voltage", cell(4.0, 4.26), FAIL, "4.26 V: too high"),
    ("cell_voltage", cell(4.0, 4.0, charging=(False, True)), UNKNOWN, "4.00 V may be the charger's"),
    ("cell_voltage", cell(3.78, 4.0, charging=(True, True)), FAIL, "3.78 V"),
    ("charging", cell(), PASS, "confirmed"),
    ("charging", cell(charging=(True, False)), FAIL, "charging"),
    ("light", light(1.9, 1.0), PASS, "1.9 V"),
    ("light", light(1.0, 2.0), FAIL, "2.0 V"),
    ("light", light(1.0, 1.0, threshold=None) | {"void": SILENT, "unanswered": {"light_threshold_v"}},
     UNKNOWN, "no reply"),
    ("light", light(2.1, 5.0) | {"profile": Profile(is_light_inverted=True)}, PASS, "2.1 V"),
    ("light", light(1.9, 5.0) | {"profile": Profile(is_light_inverted=True)}, FAIL, "1.9 V"),
    ("triggered", {"reports": still()}, PASS, "not triggered"),
    ("triggered", {"reports": still(LEVEL, FIRED)}, FAIL, "TRIGGERED"),
    ("triggered", {}, UNKNOWN, "not asked"),
    ("activation", {"reports": still(), "status": LEVEL}, PASS, "locked"),
    ("activation", {"reports": still(*[ACTIVE] * REPORTS_NEEDED), "status": ACTIVE}, PASS, "ACTIVE"),
    ("activation", {"reports": still(LEVEL, ACTIVE), "status": LEVEL}, FAIL, "changed"),
    ("connection", {"ended_at": 1.0}, PASS, "yes"),
    ("connection", {}, UNKNOWN, UNFINISHED.message.in_english()),
    ("connection", {"ended_at": 1.0, "void": SILENT}, FAIL, SILENT.message.in_english()),
    ("read_twice", {"states": [reading(), reading()]}, PASS, "yes"),
    ("read_twice", {"states": [reading(), reading(unread=("freefall_time",))]}, UNKNOWN, "not read again"),
    ("read_twice", {"states": [reading(), reading(Present(False, False, None))]}, UNKNOWN, "not read again"),
    ("read_twice", {"states": [reading(), reading()], "is_answered_twice": True}, FAIL,
     "Questions are answered twice. Two modules on this line?"),
    *(("attitude_threshold", {"profile": Profile(settings={TILT: 40}), "values": {TILT: value}}, result, f"{value}°")
      for value, result in ((39, FAIL), (40, PASS), (41, FAIL))),
    ("attitude_trigger", {"flags": {"attitude_trigger": TriggerFlag(True)}}, PASS, "enabled"),
    ("attitude_trigger", {"flags": {"attitude_trigger": TriggerFlag(False)}}, FAIL, "DISABLED"),
    ("attitude_trigger", {"flags": {"attitude_trigger": TriggerFlag(why=UserMessage("why"))}}, UNKNOWN, "why"),
)  # fmt: skip


@pytest.mark.parametrize(("check_id", "given", "result", "shown"), CASES)
def test_each_check_at_its_limit_and_one_step_beyond(
    check_id: str, given: dict[str, Any], result: CheckResult, shown: str
) -> None:
    found = finding(check_id, **given)
    assert (found.result, found.shown.in_english()) == (result, shown)


@pytest.mark.promise("h")
def test_where_30_or_31_and_the_status_differ_it_is_unknown_with_both_named() -> None:
    for present, against in (
        (Present(True, False, LEVEL), {"activation": "30: ACTIVE, status: LOCKED."}),
        (Present(False, True, LEVEL), {"triggered": "31: TRIGGERED, status: not triggered."}),
        (
            Present(None, None, LEVEL),
            {"activation": "30: no reply, status: LOCKED.", "triggered": "31: no reply, status: not triggered."},
        ),
    ):
        for states in ([reading(present), reading()], [reading(), reading(present)]):
            state: dict[str, Any] = {"states": states, "reports": still()}
            findings = {check_id: finding(check_id, **state) for check_id in ("activation", "triggered")}
            shown = {id_: one.shown.in_english() for id_, one in findings.items() if one.result is UNKNOWN}
            assert shown == against


def test_which_side_is_dark_is_assumed_until_it_was_measured() -> None:
    for verdict, limit in ((PASSED, "< 2.0 V"), (FAILED, "< 2.0 V (assumed)")):
        tested = {GuidedKind.BAY: last(verdict, 1.0)}
        assert finding("light", past=Past(tests=tested), **light(1.0, 1.0)).limit.in_english() == limit


# Settings


def test_a_setting_is_judged_by_the_advice_and_never_passes_beyond_the_bounds() -> None:
    for key, bound in SETTING_BOUNDS.items():
        step = {"attitude_threshold_deg": 1, "freefall_time_s": 0.01}.get(key, 0.1)
        fine = WARN if key == "light_threshold_v" else PASS
        for value, result in ((bound.advised_low, fine), (bound.advised_high, fine), (bound.advised_low - step, FAIL)):
            assert finding(bound.check, values={key: round(value, 2)}).result is result, (key, value)
        for value, wanted in ((bound.low - step, FAIL), (bound.low, PASS), (bound.high, PASS)):
            values: dict[str, Value] = {key: round(value, 2)}
            assert finding(bound.check, profile=Profile(settings=values), values=values).result is wanted, values
        assert finding(bound.check).result is UNKNOWN
    above: dict[str, Value] = {"attitude_threshold_deg": 91}
    assert finding("attitude_threshold", profile=Profile(settings=above), values=above).result is FAIL


def test_settings_that_were_not_approved_pass_only_by_a_persons_word() -> None:
    values = {"attitude_threshold_deg": 60, "freefall_acceleration_g": 0.5, "freefall_time_s": 1.6}
    for approved, is_said, result in (
        *(("OPQ7-5ZRY", False, PASS), ("CODE", False, FAIL), (None, False, WARN), ("CODE", True, PASS)),
    ):
        found = finding(
            "fingerprint",
            profile=Profile(approved_fingerprint=approved),
            person=Person(are_settings_approved=is_said),
            values=values | {"light_threshold_v": 1.8},
        )
        assert found.result is result
        assert ("confirmed by a person" in found.shown.in_english()) is is_said


# Which module it is, and what is kept of it


@pytest.mark.parametrize(
    ("before", "count", "is_same", "result", "shown"),
    [
        (7, 7, False, PASS, "7"),
        (7, 136, False, FAIL, "136: another module?"),
        (7, 6, False, FAIL, "6: another module?"),
        (7, 6, True, PASS, "6, confirmed by a person"),
        (None, 7, False, WARN, "7: no earlier visit"),
    ],
)
def test_a_boot_count_only_grows(
    before: int | None, count: int, is_same: bool, result: CheckResult, shown: str
) -> None:
    past = Past(module="M-07", remembered=Remembered("M-07", boot_count=before))
    found = finding("boot_count", past=past, person=Person(is_same_module=is_same), values={"boot_count": count})
    assert (found.result, found.shown.in_english()) == (result, shown)


def test_other_trigger_records_are_told_beside_the_boot_count() -> None:
    past = Past(module="M-07", remembered=Remembered("M-07", boot_count=7), do_records_follow=False)
    found = finding("boot_count", past=past, values={"boot_count": 8})
    assert (found.result, found.shown.in_english()) == (FAIL, "8: other trigger records, another module?")


def record() -> TriggerRecord:
    found = decode(RECORD)
    assert isinstance(found, TriggerRecord)
    return found


ONE, NONE, REVIEWED = (record(),), History(is_answered=True, is_confirmed=True), Counter([RECORD])
LAST = Kept(
    Row("", "visit", "M-07", "", "2026-11-02T10:00:00+00:00", ""),
    ModuleVisited(port="p", boot_count=1, slots=["00"] * 3, is_confirmed=True),
)


def records(count: int) -> History:
    return History(ONE * count, is_answered=True, is_confirmed=True)


@pytest.mark.parametrize(
    ("history", "past", "is_reviewed", "result", "shown", "word"),
    [
        (History(), Past(), False, UNKNOWN, "no reply", RecordsWord.NEW_MODULE),
        (History(), Past(), True, WARN, "no reply: new, no records", RecordsWord.NEW_MODULE),
        (History(), Past(is_said_new=True), False, WARN, "no reply: new, no records", None),
        (History(), Past(last_answer=LAST, is_said_new=True), True, FAIL, "no reply; had 3 on 2026-11-02", None),
        (NONE, Past(), False, PASS, "0 of 0 not reviewed", None),
        (History(is_answered=True), Past(), False, UNKNOWN, "readings differ", None),
        (records(1), Past(), False, UNKNOWN, "1 of 1 not reviewed", RecordsWord.REVIEWED),
        (records(1), Past(has_check=True), False, FAIL, "1 of 1 not reviewed", RecordsWord.REVIEWED),
        (records(1), Past(has_check=True), True, PASS, "all records reviewed, confirmed by a person",
         RecordsWord.REVIEWED),
        (records(1), Past(has_check=True, reviewed=REVIEWED), False, PASS, "0 of 1 not reviewed", None),
        (records(2), Past(has_check=True, reviewed=REVIEWED), False, FAIL, "1 of 2 not reviewed",
         RecordsWord.REVIEWED),
    ],
)  # fmt: skip
def test_a_new_record_is_judged_by_a_person_whose_word_is_asked_for_where_it_settles_something(
    history: History, past: Past, is_reviewed: bool, result: CheckResult, shown: str, word: RecordsWord | None
) -> None:
    person = Person(are_records_reviewed=is_reviewed)
    found = finding("trigger_records", past=past, person=person, history=history)
    assert (found.result, found.shown.in_english(), found.word) == (result, shown, word)


@pytest.mark.parametrize(("more", "result", "shown"), [
    ({"unanswered": {"light_v"}}, UNKNOWN, "no reply"),
    ({"reports": [FIRED]}, FAIL, "no reply: triggered"),
    ({"may_have_fired": True}, UNKNOWN, "may have fired before the restart"),
])  # fmt: skip
@pytest.mark.promise("f")
def test_silence_is_new_only_while_all_else_is_answered_and_nothing_may_have_fired(
    more: dict[str, Any], result: CheckResult, shown: str
) -> None:
    person = Person(are_records_reviewed=True)
    found = finding("trigger_records", past=Past(is_said_new=True), person=person, **({"history": History()} | more))
    assert (found.result, found.shown.in_english()) == (result, shown)


def last(verdict: GuidedVerdict, age_days: float | None) -> LastTested:
    return LastTested(StoredTest(kind=GuidedKind.TILT, verdict=verdict, at="2026-01-01", who="Li"), age_days)


PASSED, FAILED = GuidedVerdict.PASSED, GuidedVerdict.FAILED
OLD = {GuidedKind.TILT: last(PASSED, 400.0)}


@pytest.mark.parametrize(
    ("demanded", "tests", "result", "shown"),
    [
        ({GuidedKind.TILT: 30}, {GuidedKind.TILT: last(PASSED, 30.0)}, PASS, "Attitude trigger: passed (30 d)"),
        ({GuidedKind.TILT: 30}, {GuidedKind.TILT: last(PASSED, 30.5)}, FAIL, "Attitude trigger: passed (30 d)"),
        ({GuidedKind.TILT: 30}, {GuidedKind.TILT: last(PASSED, None)}, FAIL, "Attitude trigger: passed (? d)"),
        ({GuidedKind.TILT: 30}, {GuidedKind.TILT: last(FAILED, 1.0)}, FAIL, "Attitude trigger: FAILED (1 d)"),
        ({GuidedKind.TILT: 30}, {}, FAIL, "Attitude trigger: not tested"),
        ({}, OLD, PASS, "Attitude trigger: passed (400 d)"),
        ({}, OLD | {GuidedKind.BAY: last(FAILED, 3.0)}, WARN, "Parachute bay: FAILED (3 d)"),
    ],
)  # fmt: skip
@pytest.mark.promise("f")
def test_a_demanded_test_is_passed_and_young_enough_and_a_failed_one_is_told(
    demanded: dict[GuidedKind, int], tests: dict[GuidedKind, LastTested], result: CheckResult, shown: str
) -> None:
    profile = Profile(tests_within_days=demanded)
    found = finding("guided_tests", profile=profile, past=Past(module="M-07", tests=tests))
    assert (found.result, found.shown.in_english()) == (result, shown)
    if demanded:
        assert finding("guided_tests", profile=profile, past=Past(tests=tests)).result is UNKNOWN, "without a name"


SOON, LATE = DueService(UserMessage("Repack due"), False), DueService(UserMessage("Cell overdue"), True)
FIRED_SINCE = DueService(UserMessage("It fired"), True, is_after_firing=True)


def test_what_is_overdue_is_a_warning_or_not_met_as_the_profile_says() -> None:
    profile = Profile(is_service_required=True)
    for due, result, required in (([], PASS, PASS), ([SOON], WARN, WARN), ([SOON, LATE], WARN, FAIL)):
        past = Past(module="M-07", due=due)
        assert finding("service", past=past).result is result
        assert finding("service", past=past, profile=profile).result is required
    assert finding("service", profile=profile).result is UNKNOWN, "without a name"
    assert finding("service", past=Past(due=[FIRED_SINCE])).result is FAIL, "whatever a profile asks for"


@pytest.mark.parametrize(("name", "known"), [
    ("M-07", "M-07, named by a person"),
    (None, "module not named"),
])  # fmt: skip
@pytest.mark.promise("a")
def test_what_is_kept_under_a_name_is_used_with_the_words_by_what_the_module_is_known(
    name: str | None, known: str
) -> None:
    past = Past(module=name, fingerprint=name and "CODE")
    case = Case(evidence=Evidence(port="sim"), profile=NO_PROFILE, past=past)

    def said(case: Case) -> set[str]:
        return {one.id for one in CHECKS if one.judge(case).limit.in_english().endswith(f"; {known}")}

    of_name = {"trigger_records", "boot_count", "fingerprint", "guided_tests", "service"}
    assert said(case) == of_name
    approved = replace(case, profile=Profile(approved_fingerprint="CODE"))
    assert said(approved) == of_name - {"fingerprint"}, "by the profile, under no name"


def test_what_is_not_known_says_nothing_of_the_module() -> None:
    for check_id in ("light", "tilt", "cell_voltage", "round_trip"):
        assert finding(check_id).do == CHECK_LINK
        assert finding(check_id, void=CANCELLED).do == CHECK_AGAIN, "a cable has nothing to do with that"
    assert finding("connection", void=evidence.FIRED).do == UserMessage(FIND_OUT_WHY)
    assert finding("connection", void=SILENT).do == CHECK_LINK
    do = finding("attitude_trigger", flags={"attitude_trigger": TriggerFlag()}, status=ACTIVE).do
    assert do == UserMessage("Lock it, enable the triggers, activate it again.")
