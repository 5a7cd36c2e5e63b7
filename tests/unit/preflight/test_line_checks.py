"""The limits of the checks of the line and the sensors: what is exactly at a limit passes, one step beyond does not."""

from collections.abc import Mapping
from functools import partial
from typing import Any

import pytest

from app.engine.conversation import Interrupted, StatusSample
from app.guided.results import GuidedKind, GuidedVerdict, StoredTest
from app.limits.past import LastTested, Past
from app.preflight.evidence import HEARTBEATS, STILL_S, UNFINISHED, Evidence, StateReading, Void, void_of_end
from app.preflight.findings import CHECK_LINK, Case, CheckResult, Finding
from app.preflight.line_checks import REPORTS_NEEDED
from app.preflight.verdict import CHECKS
from app.procedures.read import Present, SettingsReading
from app.settings.profiles import NO_PROFILE, Profile
from app.text.messages import UserMessage
from protocol.catalogue import BY_NAME
from protocol.events import EndReason
from protocol.fields import Value

seen = partial(StatusSample, 0.0)
LEVEL = seen(0, 1.0, False, False)
PASS, FAIL, UNKNOWN = CheckResult.PASS, CheckResult.FAIL, CheckResult.UNKNOWN


def finding(check_id: str, profile: Profile = NO_PROFILE, **evidence: Any) -> Finding:
    case = Case(evidence=Evidence(port="sim", **evidence), profile=profile, past=Past())
    return next(check for check in CHECKS if check.id == check_id).judge(case)


def still(*statuses: StatusSample, count: int = REPORTS_NEEDED, lasting_s: float = STILL_S) -> list[StatusSample]:
    filled = [*statuses, *[LEVEL] * (count - len(statuses))]
    return [status._replace(at=lasting_s * number / (count - 1)) for number, status in enumerate(filled)]


@pytest.mark.parametrize(
    ("sent", "answered", "invalid", "result"),
    [
        (HEARTBEATS, HEARTBEATS, 0, PASS),
        (HEARTBEATS, HEARTBEATS - 1, 0, FAIL),
        (HEARTBEATS, HEARTBEATS, 1, FAIL),
        (HEARTBEATS - 1, HEARTBEATS - 1, 0, FAIL),
        (0, 0, 0, UNKNOWN),
    ],
)
def test_no_heartbeat_of_twenty_may_be_lost(sent: int, answered: int, invalid: int, result: CheckResult) -> None:
    assert HEARTBEATS == 20
    found = finding("link_loss", heartbeats_sent=sent, heartbeats_lost=sent - answered, rejected_bytes=invalid)
    assert found.result is result
    if sent:
        assert found.measured == sent - answered
        assert found.shown.in_english() == f"{sent - answered} of {sent} lost, invalid bytes: {invalid}"
    assert found.limit.in_english() == "0 of 20 lost, invalid bytes: 0"


@pytest.mark.parametrize(("slowest_s", "result"), [(0.1, PASS), (0.1001, FAIL)])
def test_the_slowest_answer_may_take_a_tenth_of_a_second(slowest_s: float, result: CheckResult) -> None:
    found = finding("round_trip", round_trips_s=[0.02, slowest_s, 0.01, 0.04])
    assert found.result is result
    assert found.shown.in_english() == f"{1000 * slowest_s:.1f} ms, median 40.0 ms"
    assert found.limit.in_english() == "≤ 100 ms"
    assert finding("round_trip").result is UNKNOWN


@pytest.mark.parametrize(
    ("count", "lasting_s", "result"),
    [
        (15, 1.5, PASS),
        (14, STILL_S, UNKNOWN),
        (15, 1.4375, UNKNOWN),
    ],
)
@pytest.mark.parametrize("check_id", ["tilt", "tilt_spread", "acceleration", "acceleration_spread"])
def test_too_few_reports_prove_nothing(check_id: str, count: int, lasting_s: float, result: CheckResult) -> None:
    found = finding(check_id, reports=still(count=count, lasting_s=lasting_s))
    assert found.result is result
    if result is UNKNOWN:
        assert found.shown.in_english() == f"reports in 2 s: only {count}"
        assert found.do == CHECK_LINK  # it may well lie level and still
    assert finding(check_id).shown.in_english() == "not asked"


@pytest.mark.parametrize(
    ("check_id", "statuses", "result", "shown", "limit"),
    [
        ("tilt", [seen(5, 1.0, False, False)], PASS, "5°", "≤ 5°"),
        ("tilt", [seen(6, 1.0, False, False)], FAIL, "6°", "≤ 5°"),
        ("tilt_spread", [seen(2, 1.0, False, False)], PASS, "2°", "≤ 2° / 2 s"),
        ("tilt_spread", [seen(3, 1.0, False, False)], FAIL, "3°", "≤ 2° / 2 s"),
        ("acceleration", [seen(0, 0.9, False, False)], PASS, "0.9 g", "0.9–1.1 g"),
        ("acceleration", [seen(0, 1.1, False, False)], PASS, "1.1 g", "0.9–1.1 g"),
        ("acceleration", [seen(0, 0.8, False, False)], FAIL, "0.8 g", "0.9–1.1 g"),
        ("acceleration", [seen(0, 1.2, False, False)], FAIL, "1.2 g", "0.9–1.1 g"),
        ("acceleration", [seen(0, 0.7, False, False), seen(0, 1.2, False, False)], FAIL, "0.7 g", "0.9–1.1 g"),
        ("acceleration_spread", [seen(0, 0.9, False, False), seen(0, 1.1, False, False)], PASS, "0.2 g",
         "≤ 0.2 g / 2 s"),
        ("acceleration_spread", [seen(0, 0.9, False, False), seen(0, 1.2, False, False)], FAIL, "0.3 g",
         "≤ 0.2 g / 2 s"),
    ],
)  # fmt: skip
def test_a_module_may_lie_and_move_up_to_the_limit(
    check_id: str, statuses: list[StatusSample], result: CheckResult, shown: str, limit: str
) -> None:
    found = finding(check_id, reports=still(*statuses))
    assert (found.result, found.shown.in_english(), found.limit.in_english()) == (result, shown, limit)


NOT_CHARGING: list[Value] = [False, False]


@pytest.mark.parametrize(
    ("series", "result", "shown"),
    [
        ({"cell_voltage_v": [3.8, 4.0], "charging": NOT_CHARGING}, PASS, "3.80 V"),
        ({"cell_voltage_v": [4.0, 3.78], "charging": NOT_CHARGING}, FAIL, "3.78 V"),
        ({"cell_voltage_v": [4.0], "charging": NOT_CHARGING}, UNKNOWN, "not asked"),
        ({"cell_voltage_v": [4.0, 4.24], "charging": NOT_CHARGING}, PASS, "4.00 V"),
        ({"cell_voltage_v": [4.0, 4.26], "charging": NOT_CHARGING}, FAIL, "4.26 V: too high"),
        ({"cell_voltage_v": [4.0, 4.0], "charging": [False]}, UNKNOWN, "4.00 V may be the charger's"),
        ({"cell_voltage_v": [4.0, 4.0], "charging": [False, True]}, UNKNOWN, "4.00 V may be the charger's"),
        ({"cell_voltage_v": [3.78, 4.0], "charging": [True, True]}, FAIL, "3.78 V"),
    ],
)
def test_the_lowest_of_the_answers_is_the_cell_voltage(
    series: Mapping[str, list[Value]], result: CheckResult, shown: str
) -> None:
    found = finding("cell_voltage", series=dict(series))
    assert (found.result, found.shown.in_english(), found.limit.in_english()) == (result, shown, "≥ 3.80 V")


@pytest.mark.parametrize(
    ("states", "result"),
    [([False, False], PASS), ([False, True], FAIL), ([True, False], FAIL), ([False], UNKNOWN), ([], UNKNOWN)],
)
def test_external_power_in_one_answer_is_enough(states: list[Value], result: CheckResult) -> None:
    found = finding("charging", series={"charging": states})
    assert found.result is result
    if result is not UNKNOWN:
        assert (found.measured, found.shown.in_english()) == (
            (True, "charging") if result is FAIL else (False, "confirmed")
        )


@pytest.mark.parametrize(
    ("lights", "result"),
    [([1.9, 1.0], PASS), ([1.0, 2.0], FAIL), ([2.1, 1.0], FAIL), ([1.0], UNKNOWN)],
)
def test_the_bay_is_closed_below_the_light_threshold(lights: list[Value], result: CheckResult) -> None:
    found = finding("light", series={"light_v": lights}, values={"light_threshold_v": 2.0})
    assert (found.result, found.limit.in_english()) == (result, "< 2.0 V (assumed)")
    assert finding("light", series={"light_v": lights}).result is UNKNOWN


@pytest.mark.parametrize(("verdict", "limit"), [("passed", "< 2.0 V"), ("failed", "< 2.0 V (assumed)")])
def test_which_side_is_dark_is_assumed_until_it_was_measured(verdict: str, limit: str) -> None:
    tested = LastTested(StoredTest(kind=GuidedKind.BAY, verdict=GuidedVerdict(verdict), at="2026-01-01", who="Li"), 1.0)
    evidence = Evidence(port="sim", series={"light_v": [1.0, 1.0]}, values={"light_threshold_v": 2.0})
    case = Case(evidence=evidence, profile=NO_PROFILE, past=Past(tests={GuidedKind.BAY: tested}))
    light = next(check for check in CHECKS if check.id == "light")
    assert light.judge(case).limit.in_english() == limit
    inverted = Case(evidence=evidence, profile=NO_PROFILE._replace(is_light_inverted=True), past=Past())
    assert light.judge(inverted).limit.in_english() == "> 2.0 V"  # its profile says what was measured


SILENT = void_of_end(Interrupted(EndReason.SILENT))


@pytest.mark.parametrize(
    ("faults", "void", "why"),
    [
        ({}, None, "not asked"),
        ({}, SILENT, "The module was silent for a moment."),
        ({"light_threshold_v": UserMessage("no reply")}, SILENT, "no reply"),
    ],
)
def test_what_is_not_known_says_why(faults: Mapping[str, UserMessage], void: Void | None, why: str) -> None:
    found = finding("light", series={"light_v": [1.0, 1.0]}, faults=faults, void=void)
    assert (found.shown.in_english(), found.do) == (why, CHECK_LINK)  # which says nothing of the bay


def test_one_report_of_many_decides() -> None:
    fired, active = seen(0, 1.0, True, False), seen(0, 1.0, False, True)
    assert finding("triggered", reports=still()).result is PASS
    assert finding("triggered", reports=still(LEVEL, fired)).shown.in_english() == "TRIGGERED"
    assert finding("activation", reports=still(), status=LEVEL).shown.in_english() == "locked"
    assert (
        finding("activation", reports=still(*[active] * REPORTS_NEEDED), status=active).shown.in_english() == "ACTIVE"
    )
    assert finding("activation", reports=still(LEVEL, active), status=LEVEL).shown.in_english() == "changed"
    for check_id in ("triggered", "activation"):
        assert finding(check_id).result is UNKNOWN


def test_a_check_that_was_interrupted_says_with_which_sentence() -> None:
    assert finding("connection", ended_at=1.0).measured is True
    assert finding("connection", ended_at=1.0).result is PASS
    assert finding("connection").result is UNKNOWN
    assert finding("connection").shown == UNFINISHED.message
    for void in (SILENT, UNFINISHED):
        found = finding("connection", ended_at=1.0, void=void)
        assert (found.result, found.measured, found.shown) == (FAIL, False, void.message)


LOCKED = Present(False, False, LEVEL)


def reading(present: Present = LOCKED, *, is_counted: bool = True, unread: tuple[str, ...] = ()) -> StateReading:
    commands = tuple(BY_NAME[name] for name in unread)
    settings = SettingsReading({"freefall_time_s": 1.6}, commands, 0.0, 7 if is_counted else None)
    return StateReading(settings, present._replace(is_counted=is_counted))


@pytest.mark.parametrize(
    ("present", "against"),
    [
        (Present(True, False, LEVEL), {"activation": "30: ACTIVE, status: LOCKED."}),
        (Present(False, True, LEVEL), {"triggered": "31: TRIGGERED, status: not triggered."}),
        (Present(None, None, LEVEL), {"activation": "30: no reply, status: LOCKED.",
                                      "triggered": "31: no reply, status: not triggered."}),
        (LOCKED, {}),
    ],
)  # fmt: skip
@pytest.mark.promise("h")
def test_where_30_or_31_and_the_status_differ_it_is_unknown_with_both_named(
    present: Present, against: dict[str, str]
) -> None:
    for when in ("first", "last"):
        state: dict[str, Any] = {when: reading(present)}
        findings = {check_id: finding(check_id, reports=still(), **state) for check_id in ("activation", "triggered")}
        said = {check_id: one.shown.in_english() for check_id, one in findings.items() if one.result is not PASS}
        assert said == against
        assert {one.result for one in findings.values()} <= {PASS, UNKNOWN}


@pytest.mark.parametrize(
    ("first", "last", "more", "result", "shown"),
    [
        (reading(), reading(), {}, PASS, "yes"),
        (reading(is_counted=False), reading(), {}, UNKNOWN, "not read again"),
        (reading(), reading(is_counted=False), {}, UNKNOWN, "not read again"),
        (reading(), reading(unread=("freefall_time",)), {}, UNKNOWN, "not read again"),
        (reading(), reading(Present(False, False, None)), {}, UNKNOWN, "not read again"),
        (None, reading(), {}, UNKNOWN, "not asked"),
        (reading(), None, {}, UNKNOWN, "not asked"),
        (reading(), reading(), {"is_answered_twice": True}, FAIL,
         "Questions are answered twice. Two modules on this line?"),
    ],
)  # fmt: skip
def test_both_readings_are_whole_and_one_module_answers(
    first: StateReading | None, last: StateReading | None, more: dict[str, Any], result: CheckResult, shown: str
) -> None:
    found = finding("read_twice", first=first, last=last, **more)
    assert (found.measured is True) is (result is PASS)
    assert (found.result, found.shown.in_english()) == (result, shown)
