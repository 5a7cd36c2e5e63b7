"""Columns of a recording for the plots, with a summary that is computed on opening."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.recordings.session_format import MAX_UPTIME_S
from app.samples.ring_buffers import SUMMARY_S, Envelope, Readable, Seconds, Values, buckets_of

_ROWS_AT_ONCE = 1 << 19
"""Bounds the memory of `beginnings` to a few megabytes."""


@dataclass(frozen=True, slots=True)
class Beginnings:
    """First rows of the buckets of `SUMMARY_S`; only the first `rows` are valid."""

    rows: int
    firsts: NDArray[np.intp]


def beginnings(times: Seconds, *values: Values) -> Beginnings:
    """Checks a table in one pass: times must be valid and ascend, values must be finite."""
    found: list[NDArray[np.intp]] = []
    newest_s, number = -math.inf, -math.inf
    for first in range(0, len(times), _ROWS_AT_ONCE):
        rows = slice(first, first + _ROWS_AT_ONCE)
        part = times[rows]
        is_bad = ~(np.abs(part) <= MAX_UPTIME_S)  # true for NaN
        is_bad[0] |= part[0] < newest_s
        is_bad[1:] |= part[1:] < part[:-1]
        for value in values:
            is_bad |= ~np.isfinite(value[rows])
        good = int(np.argmax(is_bad)) if is_bad.any() else len(part)
        if good:
            numbers = np.floor(part[:good] / SUMMARY_S)
            is_first = np.empty(good, bool)
            is_first[0] = numbers[0] != number
            np.not_equal(numbers[1:], numbers[:-1], out=is_first[1:])
            found.append(np.flatnonzero(is_first) + first)
            newest_s, number = float(part[good - 1]), float(numbers[-1])
        if good < len(part):
            return Beginnings(first + good, _joined(found))
    return Beginnings(len(times), _joined(found))


def _joined(parts: list[NDArray[np.intp]]) -> NDArray[np.intp]:
    return np.concatenate(parts) if parts else np.empty(0, np.intp)


class RecordedSeries(Readable):
    """A measured value over a whole recording. `firsts`: see `Beginnings`."""

    def __init__(self, times: Seconds, values: Values, firsts: NDArray[np.intp]) -> None:
        self._time_column, self._value_column = times, values
        self._summary = buckets_of(times, values, firsts)

    @property
    def _times(self) -> Seconds:
        return self._time_column

    @property
    def _values(self) -> Values:
        return self._value_column

    def _summary_columns(self) -> Envelope:
        return self._summary
