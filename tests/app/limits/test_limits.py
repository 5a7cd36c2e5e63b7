"""No profile goes below the hard limits; one that is softer than advised is said beside the verdict."""

import math

import pytest

from app.limits.expectations import CheckLimits, expectations_of
from app.limits.limits import SETTING_BOUNDS, softened
from app.preflight.findings import CheckResult
from app.preflight.verdict import Verdict
from app.records.filing import local_now
from app.records.record import RecordContext, caveats, make_record
from app.records.report_html import body
from app.settings.profile_file import ProfileRefused, parse_profile
from app.settings.profiles import LIMITS
from tests.support.records.preflight_rig import Fault, check

SOFT = """
[limits]
cell_voltage_min_v = 3.6
tilt_max_deg = 8
"""


def test_every_limit_has_bounds_that_hold_our_own() -> None:
    assert set(LIMITS) == set(CheckLimits.__slots__)
    for name, bound in LIMITS.items():
        assert bound.low <= getattr(CheckLimits(), name) <= bound.high
        assert bound.why
        assert math.isfinite(bound.low)


@pytest.mark.parametrize("name", LIMITS)
def test_beyond_a_bound_the_file_is_refused(name: str) -> None:
    bound = LIMITS[name]
    for value in (bound.low - 0.05, bound.high + 0.05):
        with pytest.raises(ProfileRefused) as refused:
            parse_profile(f"[limits]\n{name} = {value!r}\n".encode())
        assert refused.value.faults[0].line == 2
        assert bound.why in refused.value.sentences[0]
    for value in (bound.low, bound.high):
        parse_profile(f"[limits]\n{name} = {value!r}\n".encode())


def test_the_profile_that_let_everything_through_is_refused_all_at_once() -> None:
    text = """[limits]
cell_voltage_min_v = 0.38
tilt_max_deg = 180
heartbeats_lost_max = 20
acceleration_max_g = 25.5
acceleration_spread_max_g = 20
"""
    with pytest.raises(ProfileRefused) as refused:
        parse_profile(text.encode())
    assert [fault.line for fault in refused.value.faults] == [2, 3, 4, 5, 6]
    assert "cell_voltage_min_v: 3.5 to 4.2;" in refused.value.sentences[0]


def test_a_softer_limit_is_said_beside_the_verdict_on_the_record_and_on_the_report() -> None:
    expectations = expectations_of(parse_profile(SOFT.encode()))
    assert set(softened(expectations)) == {"cell_voltage", "tilt"}
    checked = check(Fault(frozenset(), {"cell": "3.7"}, expectations={"limits": expectations.limits}))
    assert checked.assessment.verdict is Verdict.READY
    cell = next(one.finding for one in checked.assessment.checks if one.check.id == "cell_voltage")
    assert (cell.result, cell.limit.in_english()) == (
        CheckResult.WARN, "≥ 3.60 V, advised ≥ 3.80 V",
    )  # fmt: skip
    about = RecordContext(at=local_now(), program_version="1", who="Li Wei", module="M", aircraft="B")
    record = make_record(checked.assessment, about, checked.log)
    assert record["softer_limits"] == ["tilt", "cell_voltage"]
    assert [one.in_english() for one in caveats(record)] == ["Looser than advised: Tilt: level, Cell voltage."]
    assert "Looser than advised: Tilt: level, Cell voltage." in body(record)


@pytest.mark.parametrize(("key", "raw", "name"), [
    ("attitude_threshold_deg", 200, "attitude_threshold"), ("attitude_threshold_deg", 5, "attitude_threshold"),
    ("freefall_acceleration_g", 0, "freefall_acceleration"), ("freefall_acceleration_g", 10, "freefall_acceleration"),
    ("freefall_time_s", 1, "freefall_time"), ("light_threshold_v", 0, "light_threshold"),
])  # fmt: skip
def test_no_profile_makes_such_a_setting_fit_to_fly(key: str, raw: int, name: str) -> None:
    scale = {"attitude_threshold_deg": 1, "freefall_time_s": 100}.get(key, 10)
    wanted = {"light_threshold_v": 1.8, key: raw / scale}

    def set_it(rig: object) -> None:
        setattr(rig.bench.module.memory, name, raw)  # type: ignore[attr-defined]

    checked = check(Fault(frozenset(), arrange=set_it, expectations={"settings": wanted, "approved_fingerprint": None}))
    assert checked.assessment.verdict is Verdict.NO_GO
    assert name in checked.against


def test_a_setting_outside_the_advice_is_worth_a_look() -> None:
    def set_it(rig: object) -> None:
        rig.bench.module.memory.attitude_threshold = 45  # type: ignore[attr-defined]

    wanted = {"light_threshold_v": 1.8, "attitude_threshold_deg": 45}
    checked = check(Fault(frozenset(), arrange=set_it, expectations={"settings": wanted, "approved_fingerprint": None}))
    assert checked.assessment.result("attitude_threshold") is CheckResult.WARN
    assert checked.assessment.softened == ("attitude_threshold",)
    for bound in SETTING_BOUNDS.values():
        assert bound.low <= bound.advised_low <= bound.advised_high <= bound.high
