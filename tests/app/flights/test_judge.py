"""The two triggers of the module, judged sample by sample."""

from typing import NamedTuple

import pytest

from app.flights.judge import Judge, SensorSample, TriggerLimits
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
