"""The two triggers of the module, judged sample by sample."""

import pytest

from app.flights.judge import Judge, SensorSample, TriggerLimits
from protocol.messages import Source

STEP_S = 0.01


def firings(samples: list[SensorSample], limits: TriggerLimits) -> list[tuple[SensorSample, Source]]:
    """The samples at which it fires, and why."""
    judge = Judge()
    verdicts = [(sample, judge.judge(sample, limits).fired) for sample in samples]
    return [verdict for verdict in verdicts if verdict[1]]


def fall(duration_s: float, *, acceleration_g: float = 0.1, begins_s: float = 1.0) -> list[SensorSample]:
    """A second of rest, a fall, and a second of rest."""
    count = round((begins_s + duration_s + 1.0) / STEP_S)
    times = [step * STEP_S for step in range(count)]
    return [
        SensorSample(at, 0.0, acceleration_g if begins_s - 1e-9 <= at < begins_s + duration_s - 1e-9 else 1.0)
        for at in times
    ]


@pytest.mark.parametrize(("tilts", "fires_at"), [
    (list(range(90)), [60]), ([0, 60, 51, 60], [60]), ([0, 60, 50, 60], [60, 60]),
])  # fmt: skip
def test_attitude_fires_at_the_threshold_and_rearms_ten_degrees_below(tilts: list[int], fires_at: list[int]) -> None:
    samples = [SensorSample(number * STEP_S, tilt, 1.0) for number, tilt in enumerate(tilts)]
    found = firings(samples, TriggerLimits(attitude_threshold_deg=60))
    assert [(sample.tilt_deg, source) for sample, source in found] == [(tilt, Source.ATTITUDE) for tilt in fires_at]


def with_weight(samples: list[SensorSample], row: int) -> list[SensorSample]:
    return [*samples[:row], samples[row]._replace(acceleration_g=1.0), *samples[row + 1 :]]


@pytest.mark.parametrize(("samples", "fires_s"), [
    (fall(1.59), []), (fall(1.62), [2.6]),
    (fall(3.0, acceleration_g=0.5), []), (fall(3.0, acceleration_g=0.49), [2.6]),
    (with_weight(fall(3.0), 200), [2.01 + 1.6]),
    ([SensorSample(0.0, 0.0, 0.0), SensorSample(2.0, 0.0, 0.0), SensorSample(2.1, 0.0, 0.0)], []),
])  # fmt: skip
def test_free_fall_fires_after_its_time_below_the_threshold_without_a_pause(
    samples: list[SensorSample], fires_s: list[float]
) -> None:
    found = firings(samples, TriggerLimits(freefall_acceleration_g=0.5, freefall_time_s=1.6))
    assert [(sample.at_s, source) for sample, source in found] == [
        (pytest.approx(at_s), Source.FREEFALL) for at_s in fires_s
    ]
