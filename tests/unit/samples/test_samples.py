"""Series and steps: nothing measured is lost in a picture, and memory stays flat."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.samples.samples import Series, StepFunction, StepPoint

RATE_HZ = 1440


def filled(seconds: float) -> Series:
    """A series of a sine of ±10 from 1000 s on that came in batches of a 60th of a second."""
    series = Series()
    times = 1000.0 + np.arange(int(seconds * RATE_HZ)) / RATE_HZ
    for batch in np.array_split(times, max(1, int(seconds * 60))):
        series.append(batch, 10 * np.sin(batch))
    return series


def test_an_empty_series_shows_nothing() -> None:
    series = Series()
    assert (series.last, series.first_s, len(series.decimated(0, 10).low)) == (None, math.inf, 0)


@given(
    batches=st.lists(st.lists(st.floats(0, 0.4), min_size=1, max_size=40), max_size=12),
    span_s=st.floats(0.1, 20),
    buckets=st.integers(1, 60),
    capacity=st.integers(1, 80),
)
def test_the_newest_samples_are_kept_and_every_extreme_is_drawn(
    batches: list[list[float]], span_s: float, buckets: int, capacity: int
) -> None:
    series = Series(capacity)
    times: list[float] = []
    for steps in batches:
        batch = ((times[-1] if times else 0.0) + np.cumsum(steps)).tolist()
        series.append(batch, [float(len(times) + n) % 17 for n in range(len(batch))])
        times += batch
    kept = times[-capacity:]
    values = [n % 17 for n in range(len(times))][-capacity:]
    assert [column.tolist() for column in series.window(-1.0, 1e9)] == [kept, values]
    start_s = kept[-1] / 3 if kept else 0.0
    inside = [(at, value) for at, value in zip(kept, values, strict=True) if start_s <= at <= start_s + span_s]
    envelope = series.decimated(start_s, start_s + span_s, buckets)
    assert len(envelope.low) <= buckets + 2
    for at, value in inside:
        covering = (envelope.start_s <= at) & (envelope.end_s >= at)
        assert (covering & (envelope.low <= value) & (envelope.high >= value)).any()


def test_the_picture_does_not_shimmer_while_it_scrolls() -> None:
    """Buckets that lie inside two successive views are the same in both."""
    series = filled(70)

    def inner(shift_s: float) -> set[tuple[float, ...]]:
        envelope = series.decimated(1002 + shift_s, 1062 + shift_s)
        return {tuple(map(float, row)) for row in list(zip(*envelope, strict=True))[2:-2]}

    first, second = inner(0), inner(0.033)
    assert len(first ^ second) <= 4
    assert len(first & second) > 900


def test_a_gap_stays_a_gap_and_a_line_goes_on_beyond_both_edges() -> None:
    series = Series()
    times = np.concatenate((np.arange(0, 10, 0.01), np.arange(25, 30, 0.01)))
    series.append(times, np.zeros(len(times)))
    envelope = series.decimated(0, 30, 200)
    widest = int(np.argmax(envelope.start_s[1:] - envelope.end_s[:-1]))
    assert (envelope.end_s[widest], envelope.start_s[widest + 1]) == (pytest.approx(9.99), 25)
    few = series.decimated(9.985, 25.005, 1000).start_s
    assert (few[0], few[-1] > 25.005) == (pytest.approx(9.98), True)


def test_steps_hold_what_stood_when() -> None:
    steps = StepFunction()
    assert steps.value is None
    for at, value in ((10, 60), (11, 60), (20, 75), (30, None)):
        steps.put(at, value)
    assert steps.value is None
    assert steps.between(12, 25) == [StepPoint(10, 60), StepPoint(20, 75)]
    assert steps.between(20, 25) == [StepPoint(20, 75)]
    assert steps.between(0, 15) == [StepPoint(10, 60)]
    assert steps.between(0, 5) == []
    assert steps.between(40, 50) == [StepPoint(30, None)]
