"""Finds the status reports in the bytes of the line, with numpy."""

from typing import Final, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from app.captures.line import LinePart
from protocol.catalogue import MODULE_HEADER, RECORD_CODE, STATUS, Layout

_HEAD: Final = bytes((*MODULE_HEADER, STATUS.code))
_RECORD_HEAD: Final = bytes((*MODULE_HEADER, RECORD_CODE))
_LENGTH: Final = Layout.STATUS.value
_RECORD_LENGTH: Final = Layout.RECORD.value
ACTIVE, TRIGGERED = 0x01, 0x02
"""Bits of `Reports.flags`."""


class ReportColumns(NamedTuple):
    times_ns: NDArray[np.int64]
    tilt_deg: NDArray[np.float32]
    acceleration_g: NDArray[np.float32]
    flags: NDArray[np.uint8]


class ReportFinder:
    """Takes the bytes of the module in pieces; a report may lie across two of them."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, part: LinePart) -> ReportColumns:
        """The reports that these bytes complete. The time of a report is that of its last byte."""
        data = self._rest + part.raw if self._rest else part.raw
        starts, reports = _reports_in(data)
        # Which read the last byte came in: reads are fewer than reports, so their ends are looked up.
        ends = len(self._rest) + np.cumsum(part.lengths)
        upto = np.searchsorted(starts + (_LENGTH - 1), ends)
        times = np.repeat(part.times_ns, np.diff(upto, prepend=0))
        last = int(starts[-1]) + _LENGTH if len(starts) else 0
        self._rest = data[max(last, len(data) - (_LENGTH - 1)) :]
        acceleration = reports[:, 4].astype(np.float32)
        acceleration /= np.float32(10)
        flags = reports[:, 6] * ACTIVE + reports[:, 5] * TRIGGERED
        return ReportColumns(times, reports[:, 3].astype(np.float32), acceleration, flags)


def _reports_in(data: bytes) -> tuple[NDArray[np.intp], NDArray[np.uint8]]:
    """Where the reports begin, as frame by frame from the front, and their bytes, a row for each."""
    starts, rows = _frames(data, _HEAD, _LENGTH)
    is_report = (rows[:, 5] <= 1) & (rows[:, 6] <= 1)
    if data.find(_RECORD_HEAD) >= 0:  # a trigger record may contain what looks like a report
        records, fields = _frames(data, _RECORD_HEAD, _RECORD_LENGTH)
        records = records[fields[:, 3] == 1]
        before = np.searchsorted(records, starts) - 1
        if len(records):
            is_report &= (before < 0) | (starts - records[before] >= _RECORD_LENGTH)
    starts, rows = starts[is_report], rows[is_report]
    # Two can only share the last byte of one, which is the first of the next. The one in front was taken.
    numbers, overlaps = np.arange(len(starts)), np.diff(starts, prepend=-_LENGTH) < _LENGTH
    if overlaps.any():
        is_taken = (numbers - np.maximum.accumulate(np.where(overlaps, 0, numbers))) % 2 == 0
        starts, rows = starts[is_taken], rows[is_taken]
    return starts, rows


def _frames(data: bytes, head: bytes, length: int) -> tuple[NDArray[np.intp], NDArray[np.uint8]]:
    """Begins and bytes of what has this head and the right sum, a row for each."""
    raw = np.frombuffer(data, np.uint8)
    if len(raw) < length:
        return np.empty(0, np.intp), np.empty((0, length), np.uint8)
    starts = np.flatnonzero(raw[2 : len(raw) - length + 3] == head[2])
    rows = sliding_window_view(raw, length)[starts]
    total = rows[:, 2].copy()
    for place in range(3, length - 1):
        total += rows[:, place]
    is_frame = (rows[:, 0] == head[0]) & (rows[:, 1] == head[1]) & (total == rows[:, length - 1])
    return (starts, rows) if is_frame.all() else (starts[is_frame], rows[is_frame])
