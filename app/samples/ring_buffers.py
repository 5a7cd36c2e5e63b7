"""Time series in bounded memory: exact for minutes, minimum and maximum for hours.

- Times never decrease and values are finite, else ValueError is raised.
- Samples are never averaged: an envelope has the lowest and highest sample of each bucket.
- Buckets start at multiples of their width since time 0, so that a scrolling plot does not flicker. All widths are sums
  of a few powers of two of a second, which floating point represents exactly.
- There are no empty buckets; a plot sees the gap from `end_s` to the next `start_s`.

At the default sizes about 16 MB are reserved for the exact part and 9 MB for the hours. One thread appends and reads.
"""

import math
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Seconds = NDArray[np.float64]
Values = NDArray[np.float32]

# Samples: 12 minutes of status frames as fast as 115200 baud carry them, 1,440 a second.
EXACT_SAMPLES: Final = 12 * 60 * 1440
# Width of the buckets kept for hours, in seconds.
SUMMARY_S: Final = 0.125
# Buckets kept: ten hours.
SUMMARY_BUCKETS: Final = int(10 * 3600 / SUMMARY_S)
# Reserve behind a ring, as a part of its length: it moves to the front once per that many samples.
_SLACK: Final = 0.25


class Window(NamedTuple):
    """Exact samples, oldest first: views of the series, valid until the next `append`."""

    time_s: Seconds
    value: Values


class SeriesSample(NamedTuple):
    time_s: float
    value: float


class Extent(NamedTuple):
    """The range of values around one time; `low` equals `high` for an exact sample."""

    time_s: float
    low: float
    high: float


class Envelope(NamedTuple):
    """Buckets, oldest first: time of the first and last sample of each, and its lowest and highest value."""

    start_s: Seconds
    end_s: Seconds
    low: Values
    high: Values


class _Ring:
    """Columns with the newest `capacity` rows, each contiguous in memory."""

    def __init__(self, capacity: int, *kinds: type[np.floating]) -> None:
        self.capacity = capacity
        self._length = capacity + max(1, int(capacity * _SLACK))
        self._columns = [np.empty(self._length, kind) for kind in kinds]
        self._start = 0
        self._stop = 0
        self._appended = 0

    @property
    def has_dropped(self) -> bool:
        return self._appended > self.capacity

    def __len__(self) -> int:
        return self._stop - self._start

    def clear(self) -> None:
        self._start = self._stop = self._appended = 0

    def columns(self) -> list[Any]:
        return [column[self._start : self._stop] for column in self._columns]

    def append(self, *rows: NDArray[np.floating]) -> None:
        count = len(rows[0])
        self._appended += count
        if count > self.capacity:
            rows = tuple(row[-self.capacity :] for row in rows)
            count = self.capacity
        if self._stop + count > self._length:
            kept = min(len(self), self.capacity - count)
            for column in self._columns:
                column[:kept] = column[self._stop - kept : self._stop]
            self._start, self._stop = 0, kept
        for column, row in zip(self._columns, rows, strict=True):
            column[self._stop : self._stop + count] = row
        self._stop += count
        self._start = max(self._start, self._stop - self.capacity)


class Readable:
    """One measured value over time: exact samples, and buckets of `SUMMARY_S` that may reach further back."""

    def __init__(self, times: Seconds, values: Values, summary: Envelope) -> None:
        self._times, self._values, self._summary = times, values, summary
        self._has_dropped = False
        """Whether older samples are only in the summary."""

    def __len__(self) -> int:
        return len(self._times)

    @property
    def last(self) -> SeriesSample | None:
        """The newest sample, None before the first."""
        if not len(self._times):
            return None
        return SeriesSample(float(self._times[-1]), float(self._values[-1]))

    @property
    def exact_since_s(self) -> float:
        """The time of the oldest exact sample, infinity without one."""
        return float(self._times[0]) if len(self._times) else math.inf

    def window(self, start_s: float, end_s: float) -> Window:
        """The exact samples of a span, including both ends, without copying."""
        times = self._times
        first = int(np.searchsorted(times, start_s, "left"))
        stop = int(np.searchsorted(times, end_s, "right"))
        return Window(times[first:stop], self._values[first:stop])

    def decimated(self, start_s: float, end_s: float, buckets: int = 1000) -> Envelope:
        """The span as an envelope of at most `buckets` buckets and two for the ends.

        Few samples are returned unchanged, one in each bucket, with the one before and the one after the span. The
        buckets at the ends may hold samples just outside the span. Raises ValueError for a span or a number that is
        not positive.
        """
        if not end_s > start_s or buckets < 1:
            raise ValueError(f"no picture of {buckets} buckets from {start_s} to {end_s} s")
        width_s = bucket_width_s((end_s - start_s) / buckets)
        exact_since_s, start = self.exact_since_s, self._summary.start_s
        # Equal times count as older: the exact part may have lost one of several samples of one instant.
        if self._has_dropped and start[0] <= exact_since_s and start_s <= exact_since_s:
            return self._from_summary(start_s, end_s, width_s)
        # At a slow rate the exact samples reach back further than the summary does.
        if width_s % SUMMARY_S == 0 and len(start) and start[0] <= max(start_s, exact_since_s):
            window = self.window(start_s - width_s, end_s + width_s)
            if len(window.time_s) > buckets:
                return self._from_summary(start_s, end_s, width_s)
        return self._from_exact(start_s, end_s, width_s)

    def _from_exact(self, start_s: float, end_s: float, width_s: float) -> Envelope:
        edges = _edges(start_s, end_s, width_s)
        bounds = np.searchsorted(self._times, edges, "left")
        first, stop = int(bounds[0]), int(bounds[-1])
        if stop - first + 2 <= len(edges):
            first, stop = max(0, first - 1), stop + 1
            times, values = self._times[first:stop], self._values[first:stop]
            return Envelope(times.copy(), times.copy(), values.copy(), values.copy())
        return _joined(Envelope(self._times, self._times, self._values, self._values), bounds)

    def _from_summary(self, start_s: float, end_s: float, width_s: float) -> Envelope:
        width_s = math.ceil(width_s / SUMMARY_S) * SUMMARY_S
        bounds = np.searchsorted(self._summary.start_s, _edges(start_s, end_s, width_s), "left")
        return _joined(self._summary, bounds)

    def around(self, time_s: float, *, within_s: float) -> Extent | None:
        """The sample or bucket nearest to a time, None if there is none within `within_s`."""
        if len(self._times) and time_s >= self.exact_since_s:
            times = self._times
            after = int(np.searchsorted(times, time_s, "left"))
            beside = [number for number in (after - 1, after) if 0 <= number < len(times)]
            near = min(beside, key=lambda number: abs(times[number] - time_s))
            if abs(times[near] - time_s) > within_s:
                return None
            value = float(self._values[near])
            return Extent(float(times[near]), value, value)
        start, end, low, high = self._summary
        bucket = int(np.searchsorted(end, time_s, "left"))
        if bucket >= len(start) or start[bucket] - time_s > within_s:
            return None
        return Extent(max(float(start[bucket]), time_s), float(low[bucket]), float(high[bucket]))


class Series(Readable):
    """One measured value over time.

    `capacity` is the number of exact samples kept, `summary_buckets` that of the buckets of 1/8 s. Times are monotonic
    seconds.
    """

    def __init__(self, capacity: int = EXACT_SAMPLES, *, summary_buckets: int = SUMMARY_BUCKETS) -> None:
        if capacity < 1 or summary_buckets < 2:
            raise ValueError("a series keeps one sample and two buckets at least")
        self._exact = _Ring(capacity, np.float64, np.float32)
        self._buckets = _Ring(summary_buckets, np.float64, np.float64, np.float32, np.float32)
        self._take_columns()

    def _take_columns(self) -> None:
        """Take the columns of the rings: they move."""
        self._times, self._values = self._exact.columns()
        self._summary = Envelope(*self._buckets.columns())
        self._has_dropped = self._exact.has_dropped

    def append(self, time_s: ArrayLike, value: ArrayLike) -> None:
        """Add a batch or one sample, newest last.

        Raises ValueError and adds nothing if the lengths differ, times decrease or anything is not finite.
        """
        times, values = np.array(time_s, np.float64, ndmin=1), np.array(value, np.float32, ndmin=1)
        if times.shape != values.shape or times.ndim != 1:
            raise ValueError(f"{times.shape} times for {values.shape} values")
        if not len(times):
            return
        if not (np.isfinite(times).all() and np.isfinite(values).all()):
            raise ValueError("times and values have to be finite")
        newest = self._times[-1] if len(self._exact) else -math.inf
        if times[0] < newest or (times[1:] < times[:-1]).any():
            raise ValueError("times run backwards")
        self._exact.append(times, values)
        self._summarise(times, values)
        self._take_columns()

    def _summarise(self, times: Seconds, values: Values) -> None:
        batch, (start, end, low, high) = (
            _buckets(Envelope(times, times, values, values), bucket_firsts(times)),
            self._summary,
        )
        if len(start) and math.floor(start[-1] / SUMMARY_S) == math.floor(times[0] / SUMMARY_S):
            end[-1] = batch.end_s[0]
            low[-1] = min(low[-1], batch.low[0])
            high[-1] = max(high[-1], batch.high[0])
            batch = Envelope(batch.start_s[1:], batch.end_s[1:], batch.low[1:], batch.high[1:])
        self._buckets.append(*batch)

    def clear(self) -> None:
        """Forget everything; the memory stays reserved."""
        self._exact.clear()
        self._buckets.clear()
        self._take_columns()


def bucket_width_s(at_least_s: float) -> float:
    """The narrowest width of 1, 1.25, 1.5 or 1.75 times a power of two seconds that is at least this wide."""
    power = 2.0 ** math.floor(math.log2(at_least_s))
    return math.ceil(at_least_s / power * 4) / 4 * power


def _edges(start_s: float, end_s: float, width_s: float) -> Seconds:
    """Multiples of the width from the one at or before the start to the first one after the end."""
    first, last = math.floor(start_s / width_s), math.floor(end_s / width_s) + 1
    return np.arange(first, last + 1, dtype=np.float64) * width_s


def _joined(envelope: Envelope, bounds: NDArray[np.intp]) -> Envelope:
    """One bucket from each of these rows up to the next, where there are any between them."""
    (start, end, low, high), rows = envelope, slice(bounds[0], bounds[-1])
    firsts = bounds[:-1][bounds[:-1] < bounds[1:]] - bounds[0]
    return _buckets(Envelope(start[rows], end[rows], low[rows], high[rows]), firsts)


def _buckets(envelope: Envelope, firsts: NDArray[np.intp]) -> Envelope:
    """One bucket from each index of `firsts` up to the next; none of them empty."""
    start, end, low, high = envelope
    lasts = np.concatenate((firsts, (len(start),)))[1:] - 1
    return Envelope(start[firsts], end[lasts], np.minimum.reduceat(low, firsts), np.maximum.reduceat(high, firsts))


_ROWS_AT_ONCE = 1 << 19
"""Bounds the memory of `bucket_firsts` to a few megabytes."""


def bucket_firsts(times: Seconds) -> NDArray[np.intp]:
    """First rows of the buckets of `SUMMARY_S`; `times` ascend and are finite."""
    firsts = [np.arange(min(1, len(times)))]
    for row in range(0, len(times) - 1, _ROWS_AT_ONCE):
        numbers = np.floor(times[row : row + _ROWS_AT_ONCE + 1] / SUMMARY_S)
        firsts.append((numbers[1:] != numbers[:-1]).nonzero()[0] + (row + 1))
    return np.concatenate(firsts)


class RecordedSeries(Readable):
    """A measured value that is known whole. `firsts`: `bucket_firsts` of the times."""

    def __init__(self, times: Seconds, values: Values, firsts: NDArray[np.intp]) -> None:
        super().__init__(times, values, _buckets(Envelope(times, times, values, values), firsts))
