"""Finds runs of adjacent records with numpy, which is faster than stepping through them in Python.

A run is exactly what stepping would have found. The caller steps through what lies between two runs.
"""

from array import array
from typing import Final

import numpy as np
from numpy.typing import NDArray

STEPS_BEFORE: Final = 500
"""Steps without a new definition after which a chain is worth building."""
MAX_CHAINS: Final = 20
"""Per file."""
MIN_BYTES: Final = 8
"""Average length of a record; a file with more candidates is no log and would need much memory."""
_AT_ONCE: Final = 1 << 24
_SHORT_RUN: Final = 8
_WAIT_STEPS: Final = 32


class RecordChain:
    """Candidates for records by start and end offset; `starts` ascends."""

    def __init__(self, starts: NDArray[np.int64], ends: NDArray[np.int64]) -> None:
        self.starts = starts
        self._breaks = np.append(np.flatnonzero(ends[:-1] != starts[1:]), max(0, len(starts) - 1))
        self._is_record = np.zeros(len(starts), np.bool_)
        self._waits = 0

    @property
    def records(self) -> NDArray[np.intp]:
        """Candidates that were skipped over, and so are records."""
        return np.flatnonzero(self._is_record)

    def skip(self, place: int) -> int:
        """Offset of the last record of the run that begins at `place`; `place` itself where there is no run."""
        if self._waits:  # where runs are short, searching costs more than it saves
            self._waits -= 1
            return place
        first = int(np.searchsorted(self.starts, place))
        if first >= len(self.starts) or self.starts[first] != place:
            self._waits = _WAIT_STEPS
            return place
        last = int(self._breaks[np.searchsorted(self._breaks, first)])
        self._is_record[first:last] = True
        if last - first < _SHORT_RUN:
            self._waits = _WAIT_STEPS
        return int(self.starts[last])


def positions(data: bytes, start: int, stop: int, first: int, second: int | None = None) -> NDArray[np.int64] | None:
    """Offsets of a byte, or of a pair of bytes; None where there are too many for a log."""
    raw = np.frombuffer(data, np.uint8)
    found: list[NDArray[np.int64]] = []
    for begin in range(start, stop, _AT_ONCE):
        part = raw[begin : min(stop, begin + _AT_ONCE)]
        places = np.flatnonzero(part == first) + begin
        if second is not None:
            places = places[places + 1 < stop]
            places = places[raw[places + 1] == second]
        found.append(places)
        if sum(map(len, found)) > (stop - start) // MIN_BYTES:
            return None
    return np.concatenate(found) if found else np.empty(0, np.int64)


def merge_places(places: "array[int]", more: NDArray[np.int64]) -> None:
    """Adds `more` to `places`, in order."""
    merged = np.sort(np.concatenate((np.array(places, np.int64), more)), kind="stable")
    places[:] = array("q", merged.tobytes())
