"""The two triggers of the module, judged sample by sample; judging whole arrays comes to the same."""

import random
from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import settings

from app.flights.judge import MAX_GAP_S, ROUNDING_S, Judge, SensorSample, TriggerLimits
from app.flights.samples import MAX_FIRINGS, Samples, judge_samples
from protocol.messages import Source

STEP_S = 0.01


class Firing(NamedTuple):
    """A sample at which it fires, and why."""

    sample: SensorSample
    sources: Source


def firings(samples: list[SensorSample], limits: TriggerLimits, active: list[bool] | None = None) -> list[Firing]:
    """What the judge says of one sample after the other."""
    judge = Judge()
    active = active or [True] * len(samples)
    verdicts = [
        Firing(sample, judge.judge(sample, limits, is_active=is_active).fired)
        for sample, is_active in zip(samples, active, strict=True)
    ]
    return [verdict for verdict in verdicts if verdict.sources]


def samples_of(samples: Sequence[SensorSample], active: Sequence[bool] | None = None) -> tuple[Samples, Samples]:
    """Tilt and acceleration; by default of a module that is active throughout."""
    time_s, tilt_deg, acceleration_g = np.array(samples, np.float64).reshape(-1, 3).T
    is_active = np.full(len(samples), fill_value=True) if active is None else np.array(active, np.bool_)
    return Samples(time_s, tilt_deg, is_active), Samples(time_s, acceleration_g, is_active)


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
    assert [firing.sample.at_s for firing in firings(samples, TriggerLimits(freefall_time_s=1.6))] == [
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


def tilted(*tilts: float) -> list[SensorSample]:
    return [SensorSample(n * STEP_S, tilt, 1.0) for n, tilt in enumerate(tilts)]


def test_after_a_restart_it_has_forgotten_everything() -> None:
    found = judge_samples(*samples_of(tilted(*[70.0] * 20)), TriggerLimits(), resets_s=(0.105,))
    assert [at_s for at_s, _ in found.firings] == [0.0, pytest.approx(0.11)]


def test_of_many_firings_the_first_ones_are_kept() -> None:
    found = judge_samples(*samples_of(tilted(*[0.0, 90.0] * (MAX_FIRINGS + 10))), TriggerLimits())
    assert len(found.firings) == MAX_FIRINGS
    assert found.firings[0] == (STEP_S, Source.ATTITUDE)


STEPS_S = (0.0, 0.005, 0.02, 0.1, 0.5, 0.5000001, 0.6, 2.0)
TILTS = (0.0, 5.0, 49.0, 50.0, 51.0, 59.0, 60.0, 61.0, 90.0, 180.0)
WEIGHTS = (0.0, 0.1, 0.4, 0.5, 0.6, 0.7, 1.0, 2.0)

Rows = list[tuple[float, float, float, bool]]


def cases(seed: int) -> Iterator[tuple[Rows, TriggerLimits]]:
    """Eight a test of hypothesis, which takes longer to draw one than the judge to judge it."""
    dice = random.Random(seed)
    for _ in range(8 * settings().max_examples):
        limits = TriggerLimits(
            attitude_threshold_deg=dice.choice((0.0, 5.0, 10.0, 50.0, 60.0, 61.0, 255.0)),
            freefall_acceleration_g=dice.choice((0.0, 0.1, 0.5, 0.7, 1.0, 1.5, 25.5)),
            freefall_time_s=dice.choice((0.0, 0.02, 0.1, 0.3, 0.5, 1.6)),
            attitude_is_enabled=dice.random() < 0.5,
            freefall_is_enabled=dice.random() < 0.5,
        )
        rows: Rows = []
        for _ in range(dice.randint(1, 25)):  # most things last for more than one sample
            row = dice.choice(STEPS_S), dice.choice(TILTS), dice.choice(WEIGHTS), dice.random() < 0.5
            rows += [row] * dice.randint(1, 6)
        yield rows, limits


TIPPED_WHILE_FALLING: Rows = [
    (0.1, 0.0, 1.0, True),
    (0.1, 90.0, 0.0, True),
    *((0.5, 90.0, 1.0, True),) * 4,
    *((0.5, 90.0, 0.0, True),) * 5,
]
"""The short fall is over when the long one begins: it must not count as its beginning."""


def drawn(rows: Rows) -> list[SensorSample]:
    times = accumulate((step for step, *_ in rows), initial=1e5)
    return [SensorSample(at, tilt, weight) for at, (_, tilt, weight, _) in zip(list(times)[1:], rows, strict=True)]


@pytest.mark.parametrize("is_active", [True, False])
def test_the_same_firings_as_with_every_sample(is_active: bool) -> None:
    for rows, limits in ((TIPPED_WHILE_FALLING, TriggerLimits()), *cases(is_active)):
        samples, active = drawn(rows), [row[3] or is_active for row in rows]
        found = judge_samples(*samples_of(samples, active), limits)
        expected: dict[float, Source] = {}
        for firing in firings(samples, limits, active):  # at one time it fires once, whatever the number of reports
            expected[firing.sample.at_s] = expected.get(firing.sample.at_s, Source(0)) | firing.sources
        assert list(found.firings) == list(expected.items()), (rows, limits)


def plain_miss(samples: list[SensorSample], limits: TriggerLimits) -> float:
    """The longest of the falls between samples of weight, parted by pauses; none of them where one of them fires."""
    missed = [0.0]
    block: list[list[int]] = []
    for place in range(len(samples) + 1):
        one = samples[place] if place < len(samples) else None
        if one is not None and one.acceleration_g < limits.freefall_acceleration_g:
            is_new = not block or one.at_s - samples[place - 1].at_s > MAX_GAP_S
            block.append([place]) if is_new else block[-1].append(place)
            continue
        lasted = [samples[run[-1]].at_s - samples[run[0]].at_s for run in block]
        if not any(one_s >= limits.freefall_time_s - ROUNDING_S for one_s in lasted):
            missed += lasted
        block = []
    return max(missed)


def test_the_longest_fall_that_was_too_short_is_the_one_that_the_plain_way_finds() -> None:
    for rows, limits in cases(2):
        samples = drawn(rows)
        found = judge_samples(*samples_of(samples), limits)
        expected = plain_miss(samples, limits) if limits.freefall_is_enabled else 0.0
        assert found.longest_miss_s == expected, (rows, limits)
