"""Judging whole arrays comes to the same as judging every sample."""

from itertools import accumulate

from hypothesis import example, given, settings
from hypothesis import strategies as st

from app.firing.judge import MAX_GAP_S, ROUNDING_S, SensorSample, TriggerLimits
from app.firing.what_if import MAX_NEAR_MISSES, NearFall, NearTilt, WhatIfFinding, judge_excerpt
from protocol.messages import Source
from tests.app.firing.test_judge import firings
from tests.support.records.excerpts import excerpt

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
