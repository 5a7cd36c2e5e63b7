"""Opens a recording for reading."""

import math
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import IO, Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from app.captures.entries import CaptureEntry, Way
from app.recordings.columns import RecordedSeries, beginnings, column
from app.recordings.commits import Damaged, Extents, read_extents, verified
from app.recordings.excerpt import Excerpt
from app.recordings.file_layout import (
    ACTIVE,
    COLUMNS,
    JOURNAL,
    LINE,
    TRIGGERED,
    Opening,
    Unreadable,
    is_held,
    is_time,
    journal_lines,
    read_opening,
)
from app.recordings.library import RecordingEntry, entry_of, size_of, unreadable
from app.recordings.markers import KIND_OF_WORD, Marker, MarkerKind, ModuleLimits
from app.samples.step_function import StepFunction
from app.text.messages import UserMessage, joined, message
from protocol.translatable import marked

_MAX_LIMITS = 1_000_000


class LimitsAt(NamedTuple):
    """The limits from this time on."""

    time_s: float
    limits: ModuleLimits


class RecordingUnreadable(Exception):
    def __init__(self, why: UserMessage) -> None:
        super().__init__(why.in_english())
        self._why = why

    @property
    def sentence(self) -> str:
        """Why, in the language in use now."""
        return self._why.translated()


class Recording:
    """Made by `open_recording`. Immutable; a running session is read as far as it is committed.

    Times are monotonic seconds of the recording computer; add `wall_offset_s` for seconds since 1970.
    """

    def __init__(
        self, entry: RecordingEntry, opening: Opening, extents: Extents, damaged: tuple[Damaged, ...] = ()
    ) -> None:
        """`damaged` pieces are left out. Raises OSError."""
        self.entry = entry
        self.opening = opening
        self.wall_offset_s = opening.wall_offset_s
        self._extents = extents
        self.damaged = damaged
        self.left_out_rows = 0
        """Rows behind an invalid one."""
        status = self._table("status", extents.status_rows)
        self._status_time, self._tilt, self._acceleration, self._flags = status
        self._cell_time, self._cell = self._table("cell", extents.cell_rows)
        self._light_time, self._light = self._table("light", extents.light_rows)
        self._make_series()
        self.fires, self.rearms, self.falls, self.lights = (StepFunction(_MAX_LIMITS) for _ in range(4))
        self.limits: tuple[LimitsAt, ...]
        self.markers: tuple[Marker, ...]
        self.missing_count = 0
        """Status reports and events that were lost because the disk was too slow."""
        self._read_journal()
        tables = [times for times in (self._status_time, self._cell_time, self._light_time) if len(times)]
        firsts, lasts = [float(times[0]) for times in tables], [float(times[-1]) for times in tables]
        self.start_s = min((opening.start_s, *firsts, *(one.time_s for one in self.markers[:1])))
        self.end_s = max((extents.at_s, *lasts, *(one.time_s for one in self.markers[-1:])))

    def excerpt(self, start_s: float, end_s: float) -> Excerpt:
        """The data of a span, both ends included, as views of the mapped files."""
        tilt, cell, light = (one.window(start_s, end_s) for one in (self.tilt, self.cell, self.light))
        first = int(np.searchsorted(self._status_time, start_s, "left"))
        rows = slice(first, first + len(tilt.time_s))
        flags = self._flags[rows]
        return Excerpt(
            start_s=start_s,
            end_s=end_s,
            time_s=tilt.time_s,
            tilt_deg=tilt.value,
            acceleration_g=self._acceleration[rows],
            is_triggered=(flags & TRIGGERED) != 0,
            is_active=(flags & ACTIVE) != 0,
            cell_time_s=cell.time_s,
            cell_voltage_v=cell.value,
            light_time_s=light.time_s,
            light_v=light.value,
            markers=tuple(one for one in self.markers if start_s <= one.time_s <= end_s),
        )

    def traffic(self) -> Iterator[CaptureEntry]:
        """Yields the bytes on the line in order; times count from `opening.start_s`. Raises OSError."""
        with (self.entry.folder / LINE).open("rb") as file:
            for length in self._sound(file, LINE):
                left = length
                while left > 0 and (line := file.readline(left)):
                    left -= len(line)
                    words = line.split(b" ", 2)
                    if line.startswith(b"#") or len(words) < 3:
                        continue
                    try:
                        at_s, way, raw = float(words[0]), Way(words[1].decode()), bytes.fromhex(words[2].decode())
                    except ValueError:
                        continue
                    if is_time(at_s):
                        yield CaptureEntry(at_s, way, raw)

    def _sound(self, file: IO[bytes], name: str) -> Iterator[int]:
        """Yields the lengths of the undamaged pieces of a file, positioned at the start of each."""
        place = 0
        for one in self.damaged:
            yield one.first.length(name) - place
            place = one.last.length(name)
            file.seek(place)
        yield self._extents.length(name) - place

    @property
    def line_bytes(self) -> int:
        """Length of the text that `traffic` reads, for progress."""
        return self._extents.line_bytes

    @property
    def damage(self) -> UserMessage | None:
        """What was left out as damaged or altered; None for an undamaged recording."""
        if not (self.damaged or self.left_out_rows):
            return None
        rows = self.left_out_rows + sum(
            getattr(one.last, name) - getattr(one.first, name)
            for one in self.damaged
            for name in ("status_rows", "cell_rows", "light_rows")
        )
        said = message(marked("Damaged or altered; rows left out: {rows}."), rows=f"{rows:,}")
        if not self.damaged:
            return said
        first, last = (
            f"{datetime.fromtimestamp(at_s + self.wall_offset_s).astimezone():%H:%M:%S}"
            for at_s in (self.damaged[0].first.at_s, self.damaged[-1].last.at_s)
        )
        return joined((said, message(f"{first} – {last}")), " ")

    def close(self) -> None:
        """Releases the files. Series and excerpts taken before still hold them."""
        nothing = np.empty(0)
        self._status_time = self._cell_time = self._light_time = nothing
        self._tilt = self._acceleration = self._cell = self._light = nothing.astype(np.float32)
        self._flags = nothing.astype(np.uint8)
        self._make_series()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _table(self, name: str, rows: int) -> list[NDArray[Any]]:
        folder = self.entry.folder
        columns = [column(folder / file, kind, rows) for file, kind in COLUMNS[name].items()]
        if not self.damaged:
            return columns
        places = [slice(getattr(one.first, f"{name}_rows"), getattr(one.last, f"{name}_rows")) for one in self.damaged]
        bad = np.concatenate([np.arange(one.start, one.stop) for one in places])
        return [np.delete(one, bad) for one in columns]

    def _make_series(self) -> None:
        """Leaves out the rows behind an invalid one."""
        found = len(self._status_time) + len(self._cell_time) + len(self._light_time)
        status = beginnings(self._status_time, self._tilt, self._acceleration)
        cell = beginnings(self._cell_time, self._cell)
        light = beginnings(self._light_time, self._light)
        self._status_time, self._tilt = self._status_time[: status.rows], self._tilt[: status.rows]
        self._acceleration, self._flags = self._acceleration[: status.rows], self._flags[: status.rows]
        self._cell_time, self._cell = self._cell_time[: cell.rows], self._cell[: cell.rows]
        self._light_time, self._light = self._light_time[: light.rows], self._light[: light.rows]
        self.left_out_rows += found - status.rows - cell.rows - light.rows
        self.tilt = RecordedSeries(self._status_time, self._tilt, status.firsts)
        self.acceleration = RecordedSeries(self._status_time, self._acceleration, status.firsts)
        self.cell = RecordedSeries(self._cell_time, self._cell, cell.firsts)
        self.light = RecordedSeries(self._light_time, self._light, light.firsts)

    def _read_journal(self) -> None:
        with (self.entry.folder / JOURNAL).open("rb") as file:
            raw = b"".join(file.read(length) for length in self._sound(file, JOURNAL))
        markers = [Marker(one.first.at_s, MarkerKind.DAMAGED) for one in self.damaged]
        limits: list[LimitsAt] = []
        for line in journal_lines(raw):
            at = _number(line.get("at"))
            if at is None or not is_time(at):
                continue
            match line.get("what"):
                case "happening":
                    kind = KIND_OF_WORD.get(str(line.get("kind")))
                    if kind is not None:
                        markers.append(Marker(at, kind, str(line.get("port", ""))))
                case "limits":
                    values = (_number(line.get(key)) for key in ("fires_deg", "rearms_deg", "free_fall_g", "light_v"))
                    limits.append(LimitsAt(at, ModuleLimits(*values)))
                case "missing":
                    self.missing_count += int(_number(line.get("count")) or 0)
                case _:
                    pass  # of a later version
        self.markers = tuple(sorted(markers, key=lambda one: one.time_s))
        self.limits = tuple(sorted(limits, key=lambda one: one.time_s))
        for time_s, stood in self.limits:
            self.fires.put(time_s, stood.fires_deg)
            self.rearms.put(time_s, stood.rearms_deg)
            self.falls.put(time_s, stood.free_fall_g)
            self.lights.put(time_s, stood.light_v)
        if self.limits:
            # Unknown after the end.
            end_s = max(self._extents.at_s, self.limits[-1].time_s)
            for steps in (self.fires, self.rearms, self.falls, self.lights):
                steps.put(end_s, None)


def open_recording(folder: Path) -> Recording:
    """Opens a recording; verifies all checksums unless it is being written. Takes a second or two for a long session:
    not for the window's thread. Raises `RecordingUnreadable`."""
    try:
        is_running = is_held(folder)
        opening = read_opening(folder)
        extents = read_extents(folder, opening)
        extents, damaged = (extents, ()) if is_running else verified(folder, opening, extents)
        is_running = is_running and not extents.is_last
        entry = entry_of(folder, opening, extents, size_bytes=size_of(folder), is_running=is_running)
        return Recording(entry, opening, extents, damaged)
    except (OSError, ValueError) as error:  # ValueError: `Unreadable`, or a file that shrank meanwhile
        raise RecordingUnreadable(unreadable(folder, error)) from error


def tilt_outline(folder: Path, buckets: int) -> tuple[tuple[float, float], ...]:
    """Lowest and highest tilt per interval, for a thumbnail, without verification. Empty where there is no tilt or the
    recording cannot be read."""
    try:
        opening = read_opening(folder)
        extents = read_extents(folder, opening)
        entry = entry_of(folder, opening, extents, size_bytes=0, is_running=False)
        recording = Recording(entry, opening, extents)
    except (Unreadable, OSError, ValueError):
        return ()
    try:
        found = recording.tilt.decimated(recording.start_s, max(recording.end_s, recording.start_s + 1.0), buckets)
        return tuple(zip(found.low.tolist(), found.high.tolist(), strict=True))
    finally:
        recording.close()


def _number(value: object) -> float | None:
    """A finite number, else None."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None
