"""Samples over time in bounded memory: series with their envelopes, and values that hold until the next change.

- Times never decrease, and values are finite.
- Samples are never averaged: an envelope has the lowest and highest sample of each bucket.
- Buckets start at multiples of their width since time 0, so that a scrolling plot does not flicker. All widths are sums
  of a few powers of two of a second, which floating point represents exactly.
- There are no empty buckets; a plot sees the gap from `end_s` to the next `start_s`.
"""

import math
from collections import deque
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Seconds = NDArray[np.float64]
Values = NDArray[np.float32]

# Eleven hours at 50 reports a second, or 23 minutes as fast as 115200 baud carry them. Older ones are in the recording.
MAX_SAMPLES: Final = 2_000_000
# A series that is full moves to the front of its memory once per that many samples.
_SLACK: Final = 0.25


class Window(NamedTuple):
    """Samples, oldest first: views of the series, valid until the next `append`."""

    time_s: Seconds
    value: Values


class SeriesSample(NamedTuple):
    time_s: float
    value: float


class Envelope(NamedTuple):
    """Buckets, oldest first: time of the first and last sample of each, and its lowest and highest value."""

    start_s: Seconds
    end_s: Seconds
    low: Values
    high: Values


class Readable:
    def __init__(self, times: Seconds, values: Values) -> None:
        self._times, self._values = times, values

    def __len__(self) -> int:
        return len(self._times)

    @property
    def last(self) -> SeriesSample | None:
        return self._sample(-1) if len(self) else None

    @property
    def first_s(self) -> float:
        return float(self._times[0]) if len(self) else math.inf

    def _sample(self, number: int) -> SeriesSample:
        return SeriesSample(float(self._times[number]), float(self._values[number]))

    def window(self, start_s: float, end_s: float) -> Window:
        """The samples of a span, including both ends, without copying."""
        first = int(np.searchsorted(self._times, start_s, "left"))
        stop = int(np.searchsorted(self._times, end_s, "right"))
        return Window(self._times[first:stop], self._values[first:stop])

    def around(self, time_s: float, *, within_s: float) -> SeriesSample | None:
        """The sample nearest to a time, None if there is none within `within_s`."""
        after = int(np.searchsorted(self._times, time_s, "left"))
        beside = [self._sample(number) for number in (after - 1, after) if 0 <= number < len(self)]
        near = min(beside, key=lambda sample: abs(sample.time_s - time_s), default=None)
        return near if near is not None and abs(near.time_s - time_s) <= within_s else None

    def decimated(self, start_s: float, end_s: float, buckets: int = 1000) -> Envelope:
        """The span as an envelope of at most `buckets` buckets and two for the ends.

        Few samples are returned unchanged, one in each bucket, with the one before and the one after the span. The
        buckets at the ends may hold samples just outside the span.
        """
        width_s = bucket_width_s((end_s - start_s) / buckets)
        bounds = np.searchsorted(self._times, _edges(start_s, end_s, width_s), "left")
        # A line goes on to the samples beyond both ends.
        first, stop = max(0, int(bounds[0]) - 1), min(len(self), int(bounds[-1]) + 1)
        times, values = self._times[first:stop], self._values[first:stop]
        if stop - first <= buckets:
            return Envelope(times.copy(), times.copy(), values.copy(), values.copy())
        firsts = bounds[:-1][bounds[:-1] < bounds[1:]]
        ends = np.append(firsts[1:], bounds[-1])
        inside = self._values[: bounds[-1]]
        low, high = np.minimum.reduceat(inside, firsts), np.maximum.reduceat(inside, firsts)
        return Envelope(self._times[firsts], self._times[ends - 1], low, high)


class Series(Readable):
    """One measured value over time, of which the newest `capacity` samples are kept. Times are monotonic seconds."""

    def __init__(self, capacity: int = MAX_SAMPLES) -> None:
        self._capacity = capacity
        # The system gives memory when it is first written to.
        length = capacity + max(1, int(capacity * _SLACK))
        self._memory = np.empty(length, np.float64), np.empty(length, np.float32)
        super().__init__(self._memory[0][:0], self._memory[1][:0])
        self._stop = 0

    def append(self, time_s: ArrayLike, value: ArrayLike) -> None:
        """Add a batch or one sample, newest last."""
        times, values = np.array(time_s, np.float64, ndmin=1), np.array(value, np.float32, ndmin=1)
        times, values = times[-self._capacity :], values[-self._capacity :]
        count = min(len(self), self._capacity - len(times))
        if self._stop + len(times) > len(self._memory[0]):
            for memory in self._memory:
                memory[:count] = memory[self._stop - count : self._stop]
            self._stop = count
        stop = self._stop + len(times)
        self._memory[0][self._stop : stop] = times
        self._memory[1][self._stop : stop] = values
        self._stop = stop
        self._show(count + len(times))

    def _show(self, count: int) -> None:
        times, values = self._memory
        self._times, self._values = times[self._stop - count : self._stop], values[self._stop - count : self._stop]

    def clear(self) -> None:
        self._stop = 0
        self._show(0)


def bucket_width_s(at_least_s: float) -> float:
    """The narrowest width of 1, 1.25, 1.5 or 1.75 times a power of two seconds that is at least this wide."""
    power = 2.0 ** math.floor(math.log2(at_least_s))
    return math.ceil(at_least_s / power * 4) / 4 * power


def _edges(start_s: float, end_s: float, width_s: float) -> Seconds:
    """Multiples of the width from the one at or before the start to the first one after the end."""
    first, last = math.floor(start_s / width_s), math.floor(end_s / width_s) + 1
    return np.arange(first, last + 1, dtype=np.float64) * width_s


# Changes of one setting that are kept: more than a module reports in a day.
MAX_STEPS: Final = 100_000


class StepPoint(NamedTuple):
    """The value from this time on; None: unknown."""

    time_s: float
    value: float | None


class StepFunction:
    """A setting over time: each value holds until the next one. The newest `MAX_STEPS` changes are kept."""

    def __init__(self) -> None:
        self._changes: deque[StepPoint] = deque(maxlen=MAX_STEPS)

    def clear(self) -> None:
        self._changes.clear()

    @property
    def value(self) -> float | None:
        return self._changes[-1].value if self._changes else None

    def put(self, time_s: float, value: float | None) -> None:
        """Set the value from now on; None: unknown."""
        if not self._changes or value != self.value:
            self._changes.append(StepPoint(time_s, value))

    def between(self, start_s: float, end_s: float) -> list[StepPoint]:
        """The value at `start_s`, if there is one, and every change up to `end_s`."""
        points: list[StepPoint] = []
        for change in reversed(self._changes):
            if change.time_s <= end_s:
                points.append(change)
                if change.time_s <= start_s:
                    break
        return points[::-1]
