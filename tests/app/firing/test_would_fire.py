"""Near misses and margins of measurements made by hand, what is not judged, and keeping up with what comes."""

import math
import threading
from dataclasses import dataclass, field

import numpy as np
import pytest

from app.firing.judge import SensorSample, TriggerLimits
from app.firing.what_if_series import MAX_AT_ONCE, BackgroundAnalysis, IncrementalAnalysis
from app.firing.would_fire import MAX_FIRINGS, WhatIfAnalysis, WhatIfFinding
from app.recordings.excerpt import Excerpt
from app.recordings.markers import Marker, MarkerKind
from app.samples.ring_buffers import Series
from protocol.messages import Source
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
    analysis = WhatIfAnalysis(limits or TriggerLimits(), counts_locked=counts_locked)
    analysis.feed(excerpt(samples, active=active, markers=markers, is_whole=is_whole))
    return analysis.finding


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


# Keeping up


@dataclass
class Measurements:
    """As the Live page keeps them."""

    tilt: Series = field(default_factory=Series)
    acceleration: Series = field(default_factory=Series)
    markers: tuple[Marker, ...] = ()
    looks: int = 0

    def add(self, *samples: SensorSample) -> None:
        times, tilts, weights = zip(*samples, strict=True)
        self.tilt.append(times, tilts)
        self.acceleration.append(times, weights)

    def excerpt(self, start_s: float, end_s: float) -> Excerpt:
        self.looks += 1
        times, tilts = self.tilt.window(start_s, end_s)
        weights = self.acceleration.window(start_s, end_s).value
        rows = zip(times.tolist(), tilts.tolist(), weights.tolist(), strict=True)
        return excerpt([SensorSample(*row) for row in rows])


def test_reports_are_judged_as_they_come() -> None:
    data = Measurements()
    following = IncrementalAnalysis(data, TriggerLimits())
    assert following.catch_up()
    assert (following.finding.report_count, following.progress) == (0, 1.0)
    data.add(*tilted(0, 10, 20))
    assert following.catch_up()
    data.add(SensorSample(0.06, 65.0, 1.0))
    assert following.catch_up()
    assert [one.sources for one in following.finding.firings] == [Source.ATTITUDE]
    looks = data.looks
    assert following.catch_up()
    assert data.looks == looks  # nothing new, nothing to do


def test_each_report_counts_once_also_of_one_instant() -> None:
    data = Measurements()
    following = IncrementalAnalysis(data, TriggerLimits())
    data.add(SensorSample(1.0, 0.0, 1.0), SensorSample(1.0, 1.0, 1.0))
    following.catch_up()
    data.add(SensorSample(1.0, 2.0, 1.0))
    following.catch_up()
    data.add(SensorSample(1.0, 70.0, 1.0), SensorSample(1.1, 3.0, 1.0))
    following.catch_up()
    assert following.finding.report_count == 5
    assert following.finding.firing_count == 1


def test_it_starts_over_with_another_module() -> None:
    data = Measurements()
    following = IncrementalAnalysis(data, TriggerLimits())
    data.add(*tilted(0, 70))
    following.catch_up()
    data.tilt.clear()
    data.acceleration.clear()
    while not following.catch_up():
        pass
    assert following.finding.report_count == 0
    data.add(*at_rest(3, since_s=50.0))
    while not following.catch_up():
        pass
    assert (following.finding.report_count, following.finding.firing_count) == (3, 0)


@dataclass
class Recorded:
    """Very long; `may_go_on` holds whoever reads it."""

    count: int
    may_go_on: threading.Event = field(default_factory=threading.Event)
    is_broken: bool = False

    def __post_init__(self) -> None:
        self.tilt = Series(self.count)
        self.times = np.arange(self.count) / 1000
        self.tilt.append(self.times, np.where(np.arange(self.count) == self.count - 5, 80.0, 3.0))

    def excerpt(self, start_s: float, end_s: float) -> Excerpt:
        self.may_go_on.wait(5.0)
        if self.is_broken:
            raise OSError("the disk is gone")
        times, tilts = self.tilt.window(start_s, end_s)
        none, count = np.empty(0, np.float32), len(times)
        return Excerpt(
            start_s, end_s, times, tilts, np.ones(count, np.float32), np.zeros(count, np.bool_),
            np.zeros(count, np.bool_), np.empty(0), none, np.empty(0), none, (), True,
        )  # fmt: skip


def test_a_recording_is_judged_in_pieces_in_the_background() -> None:
    data = Recorded(3 * MAX_AT_ONCE)
    data.may_go_on.set()
    judging = BackgroundAnalysis(data, TriggerLimits())
    judging.wait(10.0)
    assert judging.finding is not None
    assert (judging.finding.firing_count, judging.finding.report_count) == (1, 3 * MAX_AT_ONCE)
    assert (judging.progress, judging.error) == (1.0, None)


def test_it_can_be_cancelled() -> None:
    data = Recorded(3 * MAX_AT_ONCE)
    judging = BackgroundAnalysis(data, TriggerLimits())
    assert not judging.cancel(0.0)
    data.may_go_on.set()
    assert judging.cancel(5.0)
    assert judging.finding is None


def test_what_goes_wrong_is_told() -> None:
    data = Recorded(10, is_broken=True)
    data.may_go_on.set()
    judging = BackgroundAnalysis(data, TriggerLimits())
    assert judging.wait(5.0)
    assert isinstance(judging.error, OSError)
