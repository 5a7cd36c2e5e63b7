"""No profile goes below the hard limits; softer ones are said beside the verdict."""

import numpy as np
import pytest

from app.limits.limits import SETTING_BOUNDS, OutOfLimit, cell_outside, is_bay_open, record_outside, softened
from app.preflight.checks import CheckResult
from app.preflight.verdict import Verdict
from app.records.filing import local_now
from app.records.record import sign
from app.records.report import report_html
from app.settings.profile_file import ProfileRefused, parse_profile
from app.settings.profiles import LIMITS, NO_PROFILE, Profile
from app.trigger_records.history import sentence
from protocol.messages import TriggerRecord
from tests.support.records.preflight_rig import Fault, check
from tests.support.records.stored import station

SOFT = """
[limits]
cell_voltage_min_v = 3.6
tilt_max_deg = 8
"""


@pytest.mark.parametrize("name", LIMITS)
@pytest.mark.promise("f")
def test_beyond_a_bound_the_file_is_refused(name: str) -> None:
    bound = LIMITS[name]
    for value in (bound.low - 0.05, bound.high + 0.05):
        with pytest.raises(ProfileRefused) as refused:
            parse_profile(f"[limits]\n{name} = {value!r}\n".encode())
        assert refused.value.sentence == f"limits.{name}: expected {bound.low:g} … {bound.high:g}."
    for value in (bound.low, bound.high):
        parse_profile(f"[limits]\n{name} = {value!r}\n".encode())


@pytest.mark.promise("f")
def test_a_softer_limit_is_said_beside_the_verdict_on_the_record_and_on_the_report() -> None:
    profile = parse_profile(SOFT.encode())
    assert set(softened(profile)) == {"cell_voltage", "tilt"}
    checked = check(Fault(options={"cell": 3.7}, profile={"limits": profile.limits}))
    assert checked.assessment.verdict is Verdict.READY
    cell = next(one.finding for one in checked.assessment.checks if one.check.id == "cell_voltage")
    assert (cell.result, cell.limit.in_english()) == (
        CheckResult.WARN, "≥ 3.60 V, advised ≥ 3.80 V",
    )  # fmt: skip
    record = checked.record({"at": local_now()}, who="Li Wei", module="M", aircraft="B")
    assert record.softer_limits == ["tilt", "cell_voltage"]
    assert [caveat.in_english() for caveat in record.caveats] == ["Looser than advised: Tilt: level, Cell voltage."]
    assert "Looser than advised: Tilt: level, Cell voltage." in report_html(sign(record, station()))


def test_a_setting_outside_the_advice_is_worth_a_look() -> None:
    for key, bound in SETTING_BOUNDS.items():
        assert bound.low <= bound.advised_low <= bound.advised_high <= bound.high
        values = (bound.advised_low - 0.01, bound.advised_low, bound.advised_high, bound.advised_high + 0.01)
        assert [len(softened(Profile(settings={key: value}))) for value in values] == [1, 0, 0, 1]


# What is outside its limit is marked wherever it is shown, with its limit: one judgement for all places.


RECORD = TriggerRecord(8, 100, ("attitude",), 60, 0.5, 1.6, True, False, 1.2, 3.9, b"")
OURS = NO_PROFILE


@pytest.mark.parametrize(
    ("volts", "is_charging", "fault"),
    [
        (3.80, False, None),
        (3.79, False, OutOfLimit.CELL_LOW),
        (3.50, True, OutOfLimit.CELL_LOW),
        (3.50, None, OutOfLimit.CELL_LOW),
        (4.25, False, None),
        (4.30, False, OutOfLimit.CELL_HIGH),
        (4.70, True, None),  # the charger's
        (4.70, None, None),
    ],
)
@pytest.mark.promise("g")
def test_cell(volts: float, is_charging: bool | None, fault: OutOfLimit | None) -> None:
    found = cell_outside(volts, OURS, is_charging=is_charging)
    assert (None if found is None else found.fault) is fault


@pytest.mark.promise("g")
def test_what_was_kept_in_four_bytes_is_judged_by_its_step() -> None:
    assert cell_outside(float(np.float32(3.8)), OURS, is_charging=False) is None
    assert is_bay_open(float(np.float32(1.8)), 1.8, is_inverted=False)


@pytest.mark.promise("g")
def test_a_trigger_record_marks_a_low_cell_and_not_the_chargers() -> None:
    kept = RECORD._replace(cell_voltage_v=3.52)
    assert sentence(kept).translated().endswith("3.52 V, low")
    assert sentence(kept._replace(cell_voltage_v=3.9)).translated().endswith("3.90 V")
    assert record_outside(kept._replace(cell_voltage_v=4.7)) is None  # implausible, and marked as that
    assert record_outside(kept._replace(cell_voltage_v=4.7, charging=True)) is None
