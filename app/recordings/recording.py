"""Opens a recording for reading, and exports it for other programs."""

from array import array
from collections.abc import Callable, Iterable, Iterator
from datetime import datetime
from itertools import chain
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np

from app.captures.traffic import CaptureEntry, Way
from app.recordings.excerpt import ACTIVE, TRIGGERED, Excerpt, Measured, csv_parts, part_count
from app.recordings.library import RecordingEntry, unreadable
from app.recordings.markers import NO_LIMITS, Marker, MarkerKind, ModuleLimits
from app.recordings.session_file import (
    EVENTS,
    NANOSECONDS,
    POLLED,
    RX,
    STATUS,
    TX,
    FileMessage,
    RecordedReport,
    SessionFile,
)
from app.samples.samples import Readable
from app.system.files import whole_file
from app.system.gil_yield import GilYield
from app.text.csv_cells import object_in
from app.text.messages import UserError, UserMessage, joined, message
from protocol.translatable import marked

_MAX_LIMITS = 1_000_000
_LARGEST = 1e9
_MARKS = {kind.value: kind for kind in MarkerKind}
_WAYS = {RX: Way.IN, TX: Way.OUT}
_PAUSE_EVERY = 500
"""Reports."""


class Recording(Measured):
    """Made by `open_recording`. Immutable; a running recording is read as far as it is written.

    Times are seconds of the recording computer's clock; add `wall_offset_s` for seconds since 1970.
    """

    markers: tuple[Marker, ...]

    def __init__(self, entry: RecordingEntry) -> None:
        """Raises OSError, `UserError`."""
        super().__init__(_MAX_LIMITS)
        self.entry = entry
        self.missing_count = 0
        """Status reports and events that were lost because the disk was too slow."""
        file = SessionFile(entry.path)
        self.opening = file.opening
        self.wall_offset_s = file.opening.wall_offset_ns / NANOSECONDS
        # A day has millions of reports.
        times_ns, tilt, acceleration, flags = array("q"), array("f"), array("f"), array("B")
        self._polled: dict[str, list[tuple[float, float]]] = {key: [] for key in POLLED}
        self._limits: list[tuple[float, ModuleLimits]] = []
        markers: list[Marker] = []
        decoder, pace = msgspec.json.Decoder(RecordedReport), GilYield()
        last_ns = file.opening.start_ns
        for one in file.messages():
            last_ns = max(last_ns, one.log_ns)
            if one.topic == STATUS:
                try:
                    report = decoder.decode(one.data)
                except msgspec.DecodeError:
                    continue  # of another program
                times_ns.append(one.log_ns)
                tilt.append(report.tilt_deg)
                acceleration.append(report.acceleration_g)
                flags.append(report.active * ACTIVE | report.triggered * TRIGGERED)
                if len(flags) % _PAUSE_EVERY == 0:
                    pace.checkpoint()
            elif one.topic == EVENTS:
                markers += self._take_event(one)
        # Readers rely on ascending times.
        self._times = np.maximum.accumulate(
            (np.frombuffer(times_ns, np.int64) - file.opening.wall_offset_ns) / NANOSECONDS
        )
        self._flags = np.frombuffer(flags, np.uint8)
        self.tilt = Readable(self._times, np.frombuffer(tilt, np.float32))
        self.acceleration = Readable(self._times, np.frombuffer(acceleration, np.float32))
        self.cell = _series(self._polled["cell_voltage_v"])
        self.light = _series(self._polled["light_v"])
        self.charging = _series(self._polled["charging"])
        last_s = file.opening.clock_s(last_ns)
        self.damaged: tuple[tuple[float, float], ...] = ()
        """From when to when data is missing: up to the end, as far as that is known."""
        if file.is_damaged:
            self.damaged = ((last_s, max(last_s, file.state.end_s)),)
            markers.append(Marker(last_s, MarkerKind.DAMAGED))
        self.markers = tuple(sorted(markers, key=itemgetter(0)))
        self.start_s = min((file.opening.start_s, *(marker.time_s for marker in self.markers[:1])))
        self.end_s = max(last_s, file.state.end_s)
        for time_s, limits in sorted(self._limits, key=itemgetter(0)):
            self.put(time_s, limits)
        if self._limits:  # unknown after the end
            self.put(max(self.end_s, self._limits[-1][0]), NO_LIMITS)

    def excerpt(self, start_s: float, end_s: float) -> Excerpt:
        first, stop = np.searchsorted(self._times, start_s, "left"), np.searchsorted(self._times, end_s, "right")
        return self._excerpt(start_s, end_s, self._flags[first:stop])

    @property
    def damage(self) -> UserMessage | None:
        """What is missing in it; None for a whole recording."""
        damaged_at = self.damaged[0][0] + self.wall_offset_s if self.damaged else None
        return _damage(damaged_at, self.missing_count)

    def _take_event(self, one: FileMessage) -> Iterator[Marker]:
        """Takes in an event; one that is a mark is returned."""
        at_s, event = self.opening.clock_s(one.log_ns), object_in(one.data)
        word = event.get("event")
        self.missing_count += _missing_in(event)
        if word == "reading":
            for key, polled in self._polled.items():
                value = _number(event.get(key))
                if value is not None:
                    polled.append((at_s, value))
        elif word == "limits":
            values = [_number(event.get(key)) for key in ModuleLimits._fields]
            self._limits.append((at_s, ModuleLimits(*values)))
        elif isinstance(word, str) and word in _MARKS:
            yield Marker(at_s, _MARKS[word], str(event.get("module") or event.get("port") or ""))


class RecordedTraffic:
    """The bytes on the line in order; times count from the beginning of the recording. Raises OSError, `UserError`.
    `damage`: what was missing, known when all were read."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.damage: UserMessage | None = None

    def __iter__(self) -> Iterator[CaptureEntry]:
        file = SessionFile(self.path)
        start_ns = last_ns = file.opening.start_ns
        missing_count = 0
        for one in file.messages():
            last_ns = max(last_ns, one.log_ns)
            if one.topic in _WAYS:
                yield CaptureEntry((one.log_ns - start_ns) / NANOSECONDS, _WAYS[one.topic], one.data)
            elif one.topic == EVENTS:
                missing_count += _missing_in(object_in(one.data))
        self.damage = _damage(last_ns / NANOSECONDS if file.is_damaged else None, missing_count)


def open_recording(entry: RecordingEntry) -> Recording:
    """Opens a recording and verifies all checksums. Takes seconds for a long one: not for the window's thread. Raises
    `UserError`."""
    try:
        return Recording(entry)
    except (OSError, UserError) as error:
        raise UserError(unreadable(entry.path, error)) from error


def _damage(damaged_at: float | None, missing_count: int) -> UserMessage | None:
    """`damaged_at`: seconds since 1970."""
    missing = []
    if damaged_at is not None:
        at = datetime.fromtimestamp(damaged_at).astimezone()
        missing.append(message(marked("Damaged or altered; left out from {time} on."), time=f"{at:%H:%M:%S}"))
    if missing_count:
        text = marked("The disk was too slow. Not recorded: {count}.")
        missing.append(message(text, count=f"{missing_count:,}"))
    return joined(missing, " ") if missing else None


def _missing_in(event: dict[str, object]) -> int:
    return int(_number(event.get("count")) or 0) if event.get("event") == MarkerKind.MISSING.value else 0


def _series(polled: list[tuple[float, float]]) -> Readable:
    times, values = np.array(polled, np.float64).reshape(-1, 2).T
    return Readable(np.maximum.accumulate(times), values.astype(np.float32))


def _number(value: object) -> float | None:
    """A number that a reading or a limit can be, else None."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= _LARGEST
    return float(value) if is_number else None  # type: ignore[arg-type]


# Export

Progress = Callable[[float], object]
"""Gets 0 … 1 in the calling thread. What it raises ends the export, and the file is unchanged."""
_BLOCK_BYTES = 1 << 20


class Exported(NamedTuple):
    """`damage`: what is missing in the file, because it is damaged in the recording."""

    rows: int
    damage: UserMessage | None


def write_parts(path: Path, parts: Iterable[bytes], count: int, on_progress: Progress = bool) -> None:
    """Writes a file atomically. `count`: about how many parts. Raises OSError, and what `on_progress` raises."""
    with whole_file(path) as file:
        for number, part in enumerate(parts):
            on_progress(min(1.0, number / count))
            file.write(part)
        on_progress(1.0)


def export(
    entry: RecordingEntry, path: Path, *, is_table: bool, appends: bool = False, on_progress: Progress = bool
) -> Exported:
    """Writes a CSV table, with `appends` behind the rows of the file; or copies the session. Raises OSError,
    `UserError`, ValueError for a file that shrinks meanwhile, and what `on_progress` raises."""
    recording = open_recording(entry)
    if not is_table:
        write_parts(path, _blocks(entry.path), entry.size_bytes // _BLOCK_BYTES + 1, on_progress)
        return Exported(len(recording.tilt), recording.damage)
    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    rows = csv_parts(excerpt, wall_offset_s=recording.wall_offset_s)
    if appends and path.exists() and path.stat().st_size:
        next(rows)  # without a second head
        before = path.read_bytes()
        rows = chain((before, b"" if before.endswith(b"\n") else b"\r\n"), rows)
    write_parts(path, rows, part_count(excerpt), on_progress)
    return Exported(excerpt.row_count, recording.damage)


def _blocks(path: Path) -> Iterator[bytes]:
    with path.open("rb") as file:
        while block := file.read(_BLOCK_BYTES):
            yield block
