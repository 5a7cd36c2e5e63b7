"""Near misses and margins of measurements made by hand, and what is not judged."""

import math

import pytest

from app.firing.judge import SensorSample, TriggerLimits
from app.firing.what_if import MAX_FIRINGS, WhatIfFinding, judge_excerpt
from app.recordings.markers import Marker, MarkerKind
from tests.support.records.excerpts import excerpt

STEP_S = 0.02


def at_rest(count: int, since_s: float = 0.0) -> list[SensorSample]:
    return [SensorSample(since_s + n * STEP_S, 0.0, 1.0) for n in range(count)]


def tilted(*tilts: float) -> list[SensorSample]:
    return [SensorSample(n * STEP_S, tilt, 1.0) for n, tilt in enumerate(tilts)]


def weighed(*weights: float) -> list[SensorSample]:
    return [SensorSample(n * STEP_S, 0.0, weight) for n, weight in enumerate(weights)]


def found_in(
    samples: list[SensorSample], limits: TriggerLimits | None = None, *, active: list[bool] | None = None,
    counts_locked: bool = True, markers: tuple[Marker, ...] = (), is_whole: bool = True,
) -> WhatIfFinding:  # fmt: skip
    whole = excerpt(samples, active=active, markers=markers, is_whole=is_whole)
    return judge_excerpt(whole, limits or TriggerLimits(), counts_locked=counts_locked)


# Tilt


def test_the_nearest_approach_and_its_margin() -> None:
    found = found_in(tilted(0, 52, 57, 51, 0, 55, 40))
    assert [(one.at_s, one.tilt_deg, one.margin_deg) for one in found.near_tilts] == [
        (pytest.approx(0.04), 57, 3), (pytest.approx(0.10), 55, 5),
    ]  # fmt: skip
    assert found.nearest_tilt == found.near_tilts[0]
    assert not found.firings


def test_below_the_reset_angle_it_is_no_near_miss_but_still_the_nearest() -> None:
    found = found_in(tilted(0, 12, 30, 7))
    assert not found.near_tilts
    assert found.nearest_tilt is not None
    assert (found.nearest_tilt.tilt_deg, found.nearest_tilt.margin_deg) == (30, 30)


def test_the_way_to_a_firing_is_no_near_miss() -> None:
    found = found_in(tilted(0, 58, 59, 60, 58, 55, 50, 20))
    assert [one.sample.tilt_deg for one in found.firings] == [60]
    assert not found.near_tilts
    assert found.nearest_tilt is not None
    assert found.nearest_tilt.tilt_deg == 50


@pytest.mark.parametrize(("tilt", "is_close"), [(59, True), (58, False)])
def test_what_is_nearer_than_a_step_of_the_reports(tilt: float, is_close: bool) -> None:
    assert found_in(tilted(0, tilt, 0)).near_tilts[0].may_have_fired is is_close


# Falls


def test_a_short_fall_and_what_was_missing() -> None:
    found = found_in([*weighed(*([1.0] * 5 + [0.1] * 51 + [1.0] * 5))])
    (fall,) = found.near_falls
    assert (fall.since_s, fall.lasted_s) == (pytest.approx(0.10), pytest.approx(1.0))
    assert (fall.margin_s, fall.lowest_g) == (pytest.approx(0.6), 0.1)
    assert fall.longest_s == pytest.approx(1.04)
    assert not fall.may_have_fired
    assert found.lowest is not None
    assert found.lowest.acceleration_g == 0.1


def test_a_fall_whose_end_was_not_seen_may_have_fired() -> None:
    samples = [*weighed(*([1.0] * 5 + [0.1] * 50)), *at_rest(5, since_s=4.0)]
    (fall,) = found_in(samples).near_falls
    assert fall.lasted_s == pytest.approx(0.98)
    assert fall.may_have_fired


def test_a_fall_that_is_not_over_may_still_fire() -> None:
    (fall,) = found_in(weighed(*([1.0] * 5 + [0.1] * 50))).near_falls
    assert math.isinf(fall.longest_s)
    assert fall.may_have_fired


def test_a_fall_as_long_as_the_reports_can_tell() -> None:
    (fall,) = found_in(weighed(*([1.0] * 5 + [0.1] * 80 + [1.0] * 5))).near_falls
    assert fall.lasted_s == pytest.approx(1.58)
    assert fall.may_have_fired  # up to two reports longer


@pytest.mark.parametrize("threshold_g", [0.1 * n for n in range(1, 20)])
def test_the_threshold_itself_is_no_fall_although_values_are_kept_as_short_floats(threshold_g: float) -> None:
    limits = TriggerLimits(freefall_acceleration_g=round(threshold_g, 1), freefall_time_s=0.1)
    at, below = round(threshold_g, 1), round(threshold_g - 0.1, 1)
    assert not found_in(weighed(*[at] * 50), limits).firings
    assert len(found_in(weighed(*[below] * 50), limits).firings) == 1


# What is not judged


def test_pauses_are_not_judged() -> None:
    found = found_in([*at_rest(51), *at_rest(51, since_s=5.0), *at_rest(51, since_s=9.0)])
    assert found.judged_s == pytest.approx(3.0)
    pauses = found.pauses
    assert (pauses.count, pauses.total_s) == (2, pytest.approx(7.0))
    assert (pauses.longest_s, pauses.longest_at_s) == (pytest.approx(4.0), pytest.approx(1.0))


def test_reports_too_far_apart_tell_nothing() -> None:
    found = found_in([SensorSample(float(n), 0.0, 1.0) for n in range(20)])
    assert not found.is_judged
    assert found.report_count == 20


def test_of_a_trigger_that_is_off_nothing_is_said() -> None:
    limits = TriggerLimits(attitude_is_enabled=False, freefall_is_enabled=False)
    found = found_in([SensorSample(0.0, 90.0, 0.0), SensorSample(0.1, 90.0, 0.0)], limits)
    assert (found.firing_count, found.nearest_tilt, found.lowest, found.longest_fall) == (0, None, None, None)


def test_while_it_is_locked() -> None:
    samples, active = tilted(*[0.0] * 10, *[70.0] * 10, *[0.0] * 10), [True] * 5 + [False] * 20 + [True] * 5
    as_it_was = found_in(samples, active=active, counts_locked=False)
    as_if_active = found_in(samples, active=active, counts_locked=True)
    assert (as_it_was.firing_count, as_if_active.firing_count) == (0, 1)
    assert as_it_was.locked_s == as_if_active.locked_s == pytest.approx(0.40)
    assert (as_it_was.judged_s, as_if_active.judged_s) == (pytest.approx(0.18), pytest.approx(0.58))
    assert as_it_was.report_count == 10


def test_activated_while_tilted_it_fires_at_once() -> None:
    found = found_in(tilted(*[70.0] * 20), active=[False] * 10 + [True] * 10, counts_locked=False)
    assert [one.sample.at_s for one in found.firings] == [pytest.approx(0.20)]


@pytest.mark.parametrize("kind", [MarkerKind.RESTARTED, MarkerKind.CONNECTED])
def test_after_a_restart_it_has_forgotten_everything(kind: MarkerKind) -> None:
    samples = tilted(*[70.0] * 20)
    found = found_in(samples, markers=(Marker(0.21, kind), Marker(0.3, MarkerKind.OFFLINE)))
    assert [one.sample.at_s for one in found.firings] == [0.0, pytest.approx(0.22)]


def test_what_is_only_summed_up_is_told() -> None:
    assert not found_in(at_rest(5), is_whole=False).is_whole


def test_many_firings_are_counted_and_the_first_ones_kept() -> None:
    found = found_in(tilted(*[0.0, 90.0] * (MAX_FIRINGS + 10)))
    assert (found.firing_count, len(found.firings)) == (MAX_FIRINGS + 10, MAX_FIRINGS)
