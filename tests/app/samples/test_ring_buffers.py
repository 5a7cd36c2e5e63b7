"""Series and steps: nothing measured is lost in a picture, and memory stays flat."""

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.samples.ring_buffers import SUMMARY_BUCKETS, SUMMARY_S, Envelope, Extent, Series, SeriesSample, bucket_width_s
from app.samples.step_function import StepFunction, StepPoint

RATE_HZ = 1440


def filled(seconds: float, *, rate_hz: float = RATE_HZ, start_s: float = 1000.0, **sizes: int) -> Series:
    """A series of a sine of ±10 that came in batches of a 60th of a second."""
    series = Series(**sizes)
    times = start_s + np.arange(int(seconds * rate_hz)) / rate_hz
    values = 10 * np.sin(times)
    for batch in np.array_split(np.arange(len(times)), max(1, int(seconds * 60))):
        series.append(times[batch], values[batch])
    return series


def test_the_first_sample_and_no_sample() -> None:
    series = Series()
    assert (len(series), series.last, series.exact_since_s) == (0, None, math.inf)
    assert len(series.decimated(0, 10).low) == 0
    assert series.around(3, within_s=5) is None
    series.append(5.0, 7.0)
    assert series.last == SeriesSample(5, 7)


@pytest.mark.parametrize(
    ("times", "values"),
    [([1, 2], [1]), ([2, 1], [0, 0]), ([math.nan], [0]), ([1], [math.inf]), ([0.5], [0]), ([[1]], [[1]])],
)
def test_what_cannot_be_is_refused_and_nothing_is_added(times: list[float], values: list[float]) -> None:
    series = Series()
    series.append(0.75, 1)
    with pytest.raises(ValueError):
        series.append(times, values)
    assert len(series) == 1


def test_a_window_is_a_view() -> None:
    series = filled(2)
    window = series.window(1000.5, 1001)
    assert len(window.time_s) == RATE_HZ // 2 + 1
    assert window.time_s.base is not None
    assert (window.time_s[0], window.time_s[-1]) == (1000.5, 1001)


def test_the_envelope_is_that_of_the_samples() -> None:
    series = filled(70)
    start_s = 1005.123
    for span_s, buckets in product((0.01, 1.0, 7.3, 60.0), (1, 7, 100, 1000)):
        envelope = series.decimated(start_s, start_s + span_s, buckets)
        assert len(envelope.low) <= buckets + 2
        assert (envelope.end_s[:-1] < envelope.start_s[1:]).all()
        seen = 0
        for first_s, last_s, low, high in zip(*envelope, strict=True):
            values = series.window(first_s, last_s).value
            seen += len(values)
            assert (low, high) == (values.min(), values.max())
        assert seen == len(series.window(envelope.start_s[0], envelope.end_s[-1]).value)  # no sample between buckets
        assert envelope.start_s[0] - 1 / RATE_HZ <= start_s + 1e-9
        assert envelope.end_s[-1] + 1 / RATE_HZ >= start_s + span_s - 1e-9


@given(
    batches=st.lists(st.lists(st.floats(0, 0.4), min_size=1, max_size=40), max_size=12),
    span_s=st.floats(0.1, 20),
    buckets=st.integers(1, 60),
    capacity=st.integers(1, 80),
)
def test_old_and_new_make_one_envelope_without_loss(
    batches: list[list[float]], span_s: float, buckets: int, capacity: int
) -> None:
    """Whatever was dropped from the exact part: every extreme of the span is in the picture."""
    series = Series(capacity)
    times: list[float] = []
    for steps in batches:
        batch = ((times[-1] if times else 0.0) + np.cumsum(steps)).tolist()
        series.append(batch, [float(len(times) + n) % 17 for n in range(len(batch))])
        times += batch
    assert series.window(-1.0, 1e9).time_s.tolist() == times[-capacity:]
    assert series.exact_since_s == (times[-capacity:] or [math.inf])[0]
    values = np.array([n % 17 for n in range(len(times))], np.float32)
    start_s = times[-1] / 3 if times else 0.0
    inside = (np.array(times) >= start_s) & (np.array(times) <= start_s + span_s)
    envelope = series.decimated(start_s, start_s + span_s, buckets)
    assert len(envelope.low) <= max(buckets + 2, 1 + math.ceil(span_s / SUMMARY_S) + buckets + 2)
    assert (np.diff(envelope.start_s) >= 0).all()
    assert (envelope.start_s <= envelope.end_s).all()
    if inside.any():
        assert envelope.low.min() <= values[inside].min()
        assert envelope.high.max() >= values[inside].max()
        covered = [
            bool(((envelope.start_s <= time_s) & (envelope.end_s >= time_s)).any())
            for time_s in np.array(times)[inside]
        ]
        assert all(covered)


def test_the_picture_does_not_shimmer_while_it_scrolls() -> None:
    """Buckets that lie inside two successive views are the same in both."""
    series = filled(70)

    def inner(shift_s: float) -> set[tuple[float, ...]]:
        envelope = series.decimated(1002 + shift_s, 1062 + shift_s)
        return {tuple(map(float, row)) for row in list(zip(*envelope, strict=True))[2:-2]}

    first, second = inner(0), inner(0.033)
    assert len(first ^ second) <= 4
    assert len(first & second) > 900


def test_a_gap_stays_a_gap() -> None:
    series = Series()
    times = np.concatenate((np.arange(0, 10, 0.01), np.arange(25, 30, 0.01)))
    series.append(times, np.zeros(len(times)))
    envelope = series.decimated(0, 30, 200)
    widest = int(np.argmax(envelope.start_s[1:] - envelope.end_s[:-1]))
    assert (envelope.end_s[widest], envelope.start_s[widest + 1]) == (pytest.approx(9.99), 25)


def test_ten_hours_at_line_rate_take_no_more_memory_than_one() -> None:
    series = Series(1000)
    for minute in range(10 * 60 + 5):
        times = minute * 60 + np.arange(0, 60, 0.05)
        series.append(times, np.full(len(times), minute))
    assert len(series) == 1000
    assert len(series._buckets) == SUMMARY_BUCKETS
    held = sum(column.nbytes for ring in (series._exact, series._buckets) for column in ring._columns)
    assert held < 10_000_000
    envelope = series.decimated(0, 10 * 3600 + 300, 1000)
    assert len(envelope.low) <= 1002
    assert envelope.low.min() == pytest.approx(5, abs=1)
    assert envelope.high.max() == 604


def test_one_sample_at_a_time_takes_no_more_of_the_summary_than_many() -> None:
    one, many, times = Series(), Series(), 1000.0 + np.arange(200) / 40
    many.append(times, times)
    for time_s in times:
        one.append(time_s, time_s)
    assert len(one._buckets) == len(many._buckets) < 200


def test_slow_samples_outlive_the_summary() -> None:
    series = Series(1000, summary_buckets=20)
    series.append(np.arange(500.0), np.arange(500.0))
    envelope = series.decimated(0, 500, 50)
    assert (envelope.low.min(), envelope.high.max()) == (0, 499)
    few = series.decimated(100.5, 102.5, 50)
    assert few.start_s.tolist() == [100, 101, 102, 103], "a line goes on beyond both edges"


def test_the_reading_around_an_instant() -> None:
    series = Series(100)
    series.append(np.arange(0, 20, 0.1), np.arange(200))
    assert series.around(15.04, within_s=0.2) == pytest.approx(Extent(15.0, 150, 150))
    assert series.around(19.95, within_s=0.2) == pytest.approx(Extent(19.9, 199, 199))
    assert series.around(20.5, within_s=0.2) is None
    summed_up = series.around(3.04, within_s=0.2)
    assert summed_up is not None
    assert summed_up.low <= 30 <= summed_up.high
    assert summed_up.high - summed_up.low <= 2
    assert series.around(-1, within_s=0.2) is None


def test_clear_forgets_everything() -> None:
    series = filled(3)
    series.clear()
    assert (len(series), series.last) == (0, None)
    series.append(1, 2)
    assert isinstance(series.decimated(0, 2), Envelope)
    assert series.last == SeriesSample(1, 2)


def test_clear_keeps_the_memory_that_was_reserved() -> None:
    series = filled(3)
    before = series.window(0, 1000).time_s
    series.clear()
    series.append(1, 2)
    assert np.shares_memory(before, series.window(0, 1000).time_s)


@given(st.floats(1e-4, 1e6))
def test_bucket_widths_fit_and_are_hardly_wider_than_wanted(at_least_s: float) -> None:
    width_s = bucket_width_s(at_least_s)
    assert at_least_s <= width_s <= at_least_s * 1.2500001
    assert width_s < SUMMARY_S * 4 or width_s % SUMMARY_S == 0


def test_a_span_that_is_none_is_refused() -> None:
    for start_s, end_s, buckets in ((1.0, 1.0, 10), (2.0, 1.0, 10), (0.0, 1.0, 0)):
        with pytest.raises(ValueError):
            Series().decimated(start_s, end_s, buckets)


def test_steps_hold_what_stood_when() -> None:
    steps = StepFunction()
    assert steps.value is None
    steps.put(10, 60)
    steps.put(11, 60)
    steps.put(20, 75)
    steps.put(30, None)
    assert steps.value is None
    assert len(steps) == 3
    assert steps.between(12, 25) == [StepPoint(10, 60), StepPoint(20, 75)]
    assert steps.between(20, 25) == [StepPoint(20, 75)]
    assert steps.between(0, 15) == [StepPoint(10, 60)]
    assert steps.between(0, 5) == []
    assert steps.between(40, 50) == [StepPoint(30, None)]
    with pytest.raises(ValueError):
        steps.put(29, 1)
