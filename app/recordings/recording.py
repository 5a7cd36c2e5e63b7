"""Opens a recording for reading."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import datetime
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.captures.entries import CaptureEntry
from app.captures.line import NANOSECONDS, LineBytes, LinePart
from app.recordings.excerpt import Excerpt, Measured
from app.recordings.library import RecordingEntry, unreadable
from app.recordings.markers import NO_LIMITS, Marker, MarkerKind, ModuleLimits
from app.recordings.reports import ReportColumns, ReportFinder
from app.recordings.session_format import EVENTS, RX, TX, is_time
from app.recordings.session_reader import FileMessage, SessionFile, read_blocks
from app.samples.ring_buffers import RecordedSeries, bucket_firsts
from app.system.gil_yield import GilYield
from app.text.json_objects import object_in
from app.text.messages import UserMessage, joined, message
from app.text.user_error import UserError
from protocol.translatable import marked

_MAX_LIMITS = 1_000_000
_MAX_EXPECTED = 1 << 25
"""Rows that are believed to come before they do."""
_LARGEST = 1e9
_KINDS = (np.float64, np.float32, np.float32, np.uint8)
"""Of times, tilt, acceleration and flags."""
_MARKED = frozenset(kind.value for kind in MarkerKind)


LimitsAt = tuple[float, ModuleLimits]
"""The limits from this time on."""


class Recording(Measured):
    """Made by `open_recording`. Immutable; a running session is read as far as it is written.

    Times are monotonic seconds of the recording computer; add `wall_offset_s` for seconds since 1970.
    """

    markers: tuple[Marker, ...]

    def __init__(self, entry: RecordingEntry) -> None:
        """Raises OSError, `UserError`."""
        super().__init__(_MAX_LIMITS)
        self.entry = entry
        self.missing_count = 0
        """Status reports and events that were lost because the disk was too slow."""
        columns = _Columns(min(entry.sample_count, _MAX_EXPECTED))
        self._polled: dict[str, list[tuple[float, float]]] = {"cell_voltage_v": [], "light_v": []}
        markers: list[Marker] = []
        limits: list[LimitsAt] = []
        pace, finder = GilYield(), ReportFinder()
        for file, messages in read_blocks(entry.path):
            if not messages:  # a gap: what follows does not continue what came before
                finder = ReportFinder()
            columns.append(finder.feed(_line_part(messages, RX)), file.opening.wall_offset_ns)
            self._read_events(file, messages, markers, limits)
            pace.checkpoint()
        self.opening = file.opening
        self.wall_offset_s = self.opening.wall_offset_ns / NANOSECONDS
        self.damaged = file.gaps
        """Times between which data is missing."""
        markers += [Marker(first, MarkerKind.DAMAGED) for first, _ in self.damaged]
        self.markers = tuple(sorted(markers, key=lambda marker: marker.time_s))
        self.limits = tuple(sorted(limits, key=itemgetter(0)))
        self._times, tilt, acceleration, self._flags = columns.whole()
        firsts = bucket_firsts(self._times)
        self.tilt = RecordedSeries(self._times, tilt, firsts)
        self.acceleration = RecordedSeries(self._times, acceleration, firsts)
        self.cell, self.light = map(_series, self._polled.values())
        tables = [series for series in (self.tilt, self.cell, self.light) if len(series)]
        begins = [series.exact_since_s for series in tables] + [marker.time_s for marker in self.markers[:1]]
        self.start_s = min((self.opening.start_s, *begins))
        ends = [series.last.time_s for series in tables if series.last is not None]
        self.end_s = max((self.opening.mono_s(file.end_ns), *ends))
        for time_s, known in self.limits:
            self.put(time_s, known)
        if self.limits:  # unknown after the end
            self.put(max(self.end_s, self.limits[-1][0]), NO_LIMITS)

    def excerpt(self, start_s: float, end_s: float) -> Excerpt:
        first, stop = np.searchsorted(self._times, start_s, "left"), np.searchsorted(self._times, end_s, "right")
        return self._excerpt(start_s, end_s, self._flags[first:stop])

    @property
    def damage(self) -> UserMessage | None:
        return _damage(self.damaged, self.missing_count, self.wall_offset_s)

    def _read_events(
        self, file: SessionFile, messages: Iterable[FileMessage], markers: list[Marker], limits: list[LimitsAt]
    ) -> None:
        for _, log_ns, data in filter(lambda message: message.topic == EVENTS, messages):
            fields, at_s = object_in(data), file.opening.mono_s(log_ns)
            match fields.get("event"):
                case "reading":
                    for key, polled in self._polled.items():
                        value = _number(fields.get(key))
                        if value is not None:
                            polled.append((at_s, value))
                case "limits":
                    values = (_number(fields.get(key)) for key in ModuleLimits._fields)
                    limits.append((at_s, ModuleLimits(*values)))
                case word:
                    self.missing_count += _missing_in(fields)
                    if str(word) in _MARKED and is_time(at_s):
                        markers.append(Marker(at_s, MarkerKind(str(word)), str(fields.get("port", ""))))


class _Columns:
    """Grows to any length; what was announced is not copied."""

    def __init__(self, expected: int) -> None:
        self._count = 0
        self._columns: tuple[NDArray[Any], ...] = tuple(np.empty(expected, kind) for kind in _KINDS)

    def append(self, reports: ReportColumns, offset_ns: int) -> None:
        count = len(reports.flags)
        rows = slice(self._count, self._count + count)
        if rows.stop > len(self._columns[0]):
            more = rows.stop + rows.stop // 2
            self._columns = tuple(np.concatenate((column, np.empty(more - len(column), column.dtype)))
                                  for column in self._columns)  # fmt: skip
        times = self._columns[0][rows]
        np.divide(reports.times_ns - offset_ns, NANOSECONDS, out=times)
        parts = reports.tilt_deg, reports.acceleration_g, reports.flags
        for column, values in zip(self._columns[1:], parts, strict=True):
            column[rows] = values
        self._count = rows.stop

    def whole(self) -> tuple[NDArray[Any], ...]:
        """Times, tilt, acceleration and flags; readers rely on ascending times."""
        times, *others = (column[: self._count] for column in self._columns)
        np.maximum.accumulate(times, out=times)
        return (times, *others)


class RecordedTraffic:
    """The bytes on the line in order; times count from the beginning of the session. Raises OSError, `UserError`.
    `damage`: what was missing, known when all were read."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.damage: UserMessage | None = None

    def __iter__(self) -> Iterator[CaptureEntry]:
        missing = 0
        for file, messages in read_blocks(self.path, at_once=100):
            start_ns = file.opening.wall_ns(file.opening.start_s)
            missing += sum(_missing_in(object_in(message.data)) for message in messages if message.topic == EVENTS)
            yield from LineBytes(_line_part(messages, RX), _line_part(messages, TX)).entries(start_ns)
            self.damage = _damage(file.gaps, missing, file.opening.wall_offset_ns / NANOSECONDS)


def _missing_in(event: Mapping[str, object]) -> int:
    return int(_number(event.get("count")) or 0) if event.get("event") == MarkerKind.MISSING.value else 0


def _damage(gaps: Sequence[tuple[float, float]], missing_count: int, wall_offset_s: float) -> UserMessage | None:
    """What is missing: damaged or altered, or never written; None for a whole recording."""
    missing = []
    if gaps:
        first, last = (
            f"{datetime.fromtimestamp(at_s + wall_offset_s).astimezone():%H:%M:%S}"
            for at_s in (gaps[0][0], gaps[-1][1])
        )
        missing.append(message(marked("Damaged or altered; left out: {first} – {last}."), first=first, last=last))
    if missing_count:
        text = marked("The disk was too slow. Not recorded: {count}.")
        missing.append(message(text, count=f"{missing_count:,}"))
    return joined(missing, " ") if missing else None


def _line_part(messages: Iterable[FileMessage], topic: str) -> LinePart:
    return LinePart.read((message.log_ns, message.data) for message in messages if message.topic == topic)


def open_recording(entry: RecordingEntry) -> Recording:
    """Opens a recording and verifies all checksums. Takes a second or two for a long session: not for the window's
    thread. Raises `UserError`."""
    try:
        return Recording(entry)
    except (OSError, UserError, ValueError) as error:  # ValueError: a file that shrank meanwhile
        raise UserError(unreadable(entry.path, error)) from error


def tilt_outline(entry: RecordingEntry, buckets: int) -> tuple[tuple[float, float], ...]:
    """Lowest and highest tilt per interval, for a thumbnail. Empty where there is none, or it cannot be read."""
    try:
        recording = Recording(entry)
    except (OSError, UserError, ValueError):
        return ()
    outline = recording.tilt.decimated(recording.start_s, max(recording.end_s, recording.start_s + 1.0), buckets)
    return tuple(zip(outline.low.tolist(), outline.high.tolist(), strict=True))


def _series(polled: list[tuple[float, float]]) -> RecordedSeries:
    times, values = np.array(polled, np.float64).reshape(-1, 2).T
    times = np.maximum.accumulate(times)
    return RecordedSeries(times, values.astype(np.float32), bucket_firsts(times))


def _number(value: object) -> float | None:
    """A number that a reading or a limit can be, else None."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= _LARGEST
    return float(value) if is_number else None  # type: ignore[arg-type]
