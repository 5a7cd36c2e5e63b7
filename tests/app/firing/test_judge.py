"""The two triggers of the module, judged sample by sample; judging whole arrays comes to the same."""

from itertools import accumulate

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from app.firing.judge import MAX_GAP_S, ROUNDING_S, Firing, Judge, SensorSample, TriggerLimits
from app.firing.what_if import MAX_NEAR_MISSES, NearFall, NearTilt, WhatIfFinding, judge_excerpt
from protocol.messages import Source
from tests.support.records.excerpts import excerpt

STEP_S = 0.01


def firings(samples: list[SensorSample], limits: TriggerLimits, active: list[bool] | None = None) -> list[Firing]:
    """What the judge says of one sample after the other."""
    judge = Judge()
    active = active or [True] * len(samples)
    verdicts = [
        Firing(sample, judge.judge(sample, limits, is_active=is_active).fired)
        for sample, is_active in zip(samples, active, strict=True)
    ]
    return [verdict for verdict in verdicts if verdict.sources]


def fall(duration_s: float, *, acceleration_g: float = 0.1, begins_s: float = 1.0) -> list[SensorSample]:
    """A second of rest, a fall, and a second of rest."""
    count = round((begins_s + duration_s + 1.0) / STEP_S)
    times = [step * STEP_S for step in range(count)]
    return [
        SensorSample(at, 0.0, acceleration_g if begins_s - 1e-9 <= at < begins_s + duration_s - 1e-9 else 1.0)
        for at in times
    ]


def test_attitude_fires_at_the_threshold_and_once() -> None:
    samples = [SensorSample(tilt * STEP_S, tilt, 1.0) for tilt in range(90)]
    found = firings(samples, TriggerLimits(attitude_threshold_deg=60))
    assert [(one.sample.tilt_deg, one.sources) for one in found] == [(60, Source.ATTITUDE)]


@pytest.mark.parametrize(("lowest_deg", "expected"), [(51, 1), (50, 2)])
def test_attitude_resets_ten_degrees_below_the_threshold(lowest_deg: int, expected: int) -> None:
    tilts = [0, 60, lowest_deg, 60]
    samples = [SensorSample(number * STEP_S, tilt, 1.0) for number, tilt in enumerate(tilts)]
    assert len(firings(samples, TriggerLimits(attitude_threshold_deg=60))) == expected


@pytest.mark.parametrize(("duration_s", "fires"), [(1.59, False), (1.62, True)])
def test_free_fall_fires_after_its_time(duration_s: float, fires: bool) -> None:
    found = list(firings(fall(duration_s), TriggerLimits(freefall_time_s=1.6)))
    assert bool(found) is fires
    if fires:
        assert found[0].sources == Source.FREEFALL
        assert found[0].sample.at_s == pytest.approx(1.0 + 1.6)


def test_acceleration_at_the_threshold_is_no_fall() -> None:
    assert not list(firings(fall(3.0, acceleration_g=0.5), TriggerLimits(freefall_acceleration_g=0.5)))
    assert list(firings(fall(3.0, acceleration_g=0.49), TriggerLimits(freefall_acceleration_g=0.5)))


def test_one_sample_of_weight_starts_the_fall_again() -> None:
    samples = fall(3.0)
    samples[200] = samples[200]._replace(acceleration_g=1.0)
    assert [one.sample.at_s for one in firings(samples, TriggerLimits(freefall_time_s=1.6))] == [
        pytest.approx(2.01 + 1.6)
    ]


def test_a_gap_in_a_recording_proves_no_fall() -> None:
    samples = [SensorSample(0.0, 0.0, 0.0), SensorSample(2.0, 0.0, 0.0), SensorSample(2.1, 0.0, 0.0)]
    assert not list(firings(samples, TriggerLimits(freefall_time_s=1.6)))


@pytest.mark.parametrize(("is_enabled", "fired"), [(True, Source.ATTITUDE | Source.FREEFALL), (False, Source(0))])
def test_both_fire_together_and_what_is_disabled_does_not(is_enabled: bool, fired: Source) -> None:
    limits = TriggerLimits(freefall_time_s=0.0, attitude_is_enabled=is_enabled, freefall_is_enabled=is_enabled)
    assert Judge().judge(SensorSample(0.0, 80.0, 0.0), limits).fired == fired


def test_a_locked_module_never_fires_and_forgets_a_fall() -> None:
    judge = Judge()
    limits = TriggerLimits(freefall_time_s=1.0)
    for step in range(300):
        assert not judge.judge(SensorSample(step * STEP_S, 80.0, 0.0), limits, is_active=False).fired
    assert judge.judge(SensorSample(3.0, 0.0, 0.0), limits).fired == Source(0)
    assert judge.judge(SensorSample(3.4, 0.0, 0.0), limits).fired == Source(0)
    assert judge.judge(SensorSample(3.8, 0.0, 0.0), limits).fired == Source(0)
    assert judge.judge(SensorSample(4.0, 0.0, 0.0), limits).fired == Source.FREEFALL


STEPS_S = (0.0, 0.005, 0.02, 0.1, 0.5, 0.5000001, 0.6, 2.0)
TILTS = (0.0, 5.0, 49.0, 50.0, 51.0, 59.0, 60.0, 61.0, 90.0, 180.0)
WEIGHTS = (0.0, 0.1, 0.4, 0.5, 0.6, 0.7, 1.0, 2.0)

limits_drawn = st.builds(
    TriggerLimits,
    attitude_threshold_deg=st.sampled_from((0.0, 5.0, 10.0, 50.0, 60.0, 61.0, 255.0)),
    freefall_acceleration_g=st.sampled_from((0.0, 0.1, 0.5, 0.7, 1.0, 1.5, 25.5)),
    freefall_time_s=st.sampled_from((0.0, 0.02, 0.1, 0.3, 0.5, 1.6)),
    attitude_is_enabled=st.booleans(),
    freefall_is_enabled=st.booleans(),
)
one_drawn = st.tuples(st.sampled_from(STEPS_S), st.sampled_from(TILTS), st.sampled_from(WEIGHTS), st.booleans())
rows_drawn = st.lists(st.tuples(one_drawn, st.integers(1, 6)), min_size=1, max_size=25).map(
    lambda drawn: [one for one, count in drawn for _ in range(count)]  # most things last for more than one sample
)
Rows = list[tuple[float, float, float, bool]]

TIPPED_WHILE_FALLING: Rows = [
    (0.1, 0.0, 1.0, True),
    (0.1, 90.0, 0.0, True),
    *((0.5, 90.0, 1.0, True),) * 4,
    *((0.5, 90.0, 0.0, True),) * 5,
]
"""The short fall is over when the long one begins: it must not count as its beginning."""


def samples_of(rows: Rows) -> list[SensorSample]:
    times = accumulate((step for step, *_ in rows), initial=1e5)
    return [SensorSample(at, tilt, weight) for at, (_, tilt, weight, _) in zip(list(times)[1:], rows, strict=True)]


def judged(samples: list[SensorSample], active: list[bool], limits: TriggerLimits) -> WhatIfFinding:
    return judge_excerpt(excerpt(samples, active=active), limits, counts_locked=False)


@given(rows_drawn, limits_drawn, st.booleans())
@settings(max_examples=400)
@example(TIPPED_WHILE_FALLING, TriggerLimits(), True)
def test_the_same_firings_as_with_every_sample(rows: Rows, limits: TriggerLimits, locked: bool) -> None:
    samples, active = samples_of(rows), [row[3] or locked for row in rows]
    found = judged(samples, active, limits)
    assert list(found.firings) == firings(samples, limits, active)
    assert found.firing_count == len(found.firings)


# Near misses, looked for in the plain way


def plain_tilts(samples: list[SensorSample], limits: TriggerLimits) -> list[NearTilt]:
    """The peak of each stay above the reset angle that stays below the threshold."""
    stays: list[list[SensorSample]] = [[]]
    for one in samples:
        if one.tilt_deg > limits.reset_angle_deg:
            stays[-1].append(one)
        elif stays[-1]:
            stays.append([])
    peaks = [max(stay, key=lambda one: one.tilt_deg) for stay in stays if stay]
    near = [
        NearTilt(one.at_s, one.tilt_deg, limits.attitude_threshold_deg - one.tilt_deg)
        for one in peaks if one.tilt_deg < limits.attitude_threshold_deg
    ]  # fmt: skip
    return sorted(near, key=lambda one: (one.margin_deg, one.at_s))[:MAX_NEAR_MISSES]


def plain_falls(samples: list[SensorSample], limits: TriggerLimits) -> list[NearFall]:
    """Falls between samples of weight, parted by pauses; none of them where one of them fires."""
    found: list[NearFall] = []
    block: list[list[int]] = []
    after_s = limits.freefall_time_s
    for place in range(len(samples) + 1):
        one = samples[place] if place < len(samples) else None
        if one is not None and one.acceleration_g < limits.freefall_acceleration_g:
            is_new = not block or one.at_s - samples[place - 1].at_s > MAX_GAP_S
            block.append([place]) if is_new else block[-1].append(place)
            continue
        lasted = [samples[run[-1]].at_s - samples[run[0]].at_s for run in block]
        if not any(one_s >= after_s - ROUNDING_S for one_s in lasted):
            for run, lasted_s in zip(block, lasted, strict=True):
                before_s = samples[run[0] - 1].at_s if run[0] else float("-inf")
                next_s = samples[run[-1] + 1].at_s if run[-1] + 1 < len(samples) else float("inf")
                lowest_g = min(samples[n].acceleration_g for n in run)
                since_s = samples[run[0]].at_s
                found.append(NearFall(since_s, lasted_s, after_s - lasted_s, lowest_g, next_s - before_s))
        block = []
    return sorted(found, key=lambda one: (one.margin_s, one.since_s))[:MAX_NEAR_MISSES]


@given(rows_drawn, limits_drawn)
def test_near_misses_are_those_that_the_plain_way_finds(rows: Rows, limits: TriggerLimits) -> None:
    samples = samples_of(rows)
    found = judged(samples, [True] * len(samples), limits)
    assert list(found.near_tilts) == (plain_tilts(samples, limits) if limits.attitude_is_enabled else [])
    assert list(found.near_falls) == (plain_falls(samples, limits) if limits.freefall_is_enabled else [])


@given(rows_drawn, limits_drawn)
def test_a_near_miss_did_not_fire(rows: Rows, limits: TriggerLimits) -> None:
    samples = samples_of(rows)
    found = judged(samples, [True] * len(samples), limits)
    fired = {one.sample.at_s for one in found.firings if Source.FREEFALL in one.sources}
    for fall in found.near_falls:
        assert not any(fall.since_s <= at <= fall.since_s + fall.lasted_s for at in fired) or fall.lasted_s == 0
    assert all(one.margin_deg > 0 for one in found.near_tilts)
