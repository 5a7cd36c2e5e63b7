"""What was seen on the Live page as a file: CSV, and how any file is written so that there is never half of one."""

import os
import threading
from collections.abc import Callable, Iterable, Iterator
from datetime import datetime
from pathlib import Path
from typing import Final

import numpy as np

from ui.live_data import Happening, Kind, Recording

HEAD: Final = "time,elapsed_s,tilt_deg,acceleration_g,triggered,active,cell_voltage_v,light_v,event"
# Rows between two looks at whether somebody wants it to stop: some 10 ms.
_ROWS_AT_ONCE: Final = 5000
_END: Final = "\r\n"


class Cancelled(Exception):
    """Somebody stopped the writing; the file is as it was before."""


def csv_parts(recording: Recording, *, wall_offset_s: float) -> Iterator[bytes]:
    """The recording in UTF-8 with a byte-order mark, in pieces.

    One row per status report, and rows of their own for cell voltage, light and events, in order of time; what
    a row does not tell is empty.  ``wall_offset_s`` added to the recording's times gives seconds since 1970;
    ``elapsed_s`` counts from the first row.
    """
    yield f"\ufeff{HEAD}{_END}".encode()
    stamp = Stamp(wall_offset_s, first_s=recording.first_s)
    lines: list[str] = []
    for line in _lines(recording, stamp):
        lines.append(line)
        if len(lines) == _ROWS_AT_ONCE:
            yield "".join(lines).encode()
            lines.clear()
    yield "".join(lines).encode()


def part_count(recording: Recording) -> int:
    """How many pieces ``csv_parts`` has."""
    return recording.row_count // _ROWS_AT_ONCE + 2


def _lines(recording: Recording, stamp: "Stamp") -> Iterator[str]:
    others = sorted(_other_cells(recording))
    places = np.searchsorted(recording.time_s, [at for at, _ in others], "right").tolist()
    row = 0
    for (at, cells), place in zip(others, places, strict=True):
        yield from _status_lines(recording, stamp, row, place)
        row = place
        yield f"{stamp.at(at)},,,,,{cells}{_END}"
    yield from _status_lines(recording, stamp, row, len(recording.time_s))


def _status_lines(recording: Recording, stamp: "Stamp", start: int, stop: int) -> Iterator[str]:
    for first in range(start, stop, _ROWS_AT_ONCE):
        part = slice(first, min(stop, first + _ROWS_AT_ONCE))
        columns = zip(
            recording.time_s[part].tolist(),
            recording.tilt_deg[part].tolist(),
            recording.acceleration_g[part].tolist(),
            recording.is_triggered[part].tolist(),
            recording.is_active[part].tolist(),
            strict=True,
        )
        for at, tilt, acceleration, is_triggered, is_active in columns:
            yield f"{stamp.at(at)},{tilt:g},{acceleration:.1f},{is_triggered:d},{is_active:d},,,{_END}"


def _other_cells(recording: Recording) -> Iterator[tuple[float, str]]:
    """Time, and the last three cells of the row."""
    for at, volts in zip(recording.cell_time_s.tolist(), recording.cell_voltage_v.tolist(), strict=True):
        yield at, f"{volts:.2f},,"
    for at, volts in zip(recording.light_time_s.tolist(), recording.light_v.tolist(), strict=True):
        yield at, f",{volts:.1f},"
    for happening in recording.happenings:
        yield happening.time_s, f",,{_quoted(_event_text(happening))}"


def _event_text(happening: Happening) -> str:
    names_port = happening.kind in (Kind.CONNECTED, Kind.RECORDING, Kind.RECONNECTED, Kind.PORT_LOST)
    return f"{happening.kind.value}: {happening.port}" if names_port and happening.port else happening.kind.value


def _quoted(text: str) -> str:
    if any(one in text for one in ',"\r\n'):
        return '"' + text.replace('"', '""') + '"'
    return text


class Stamp:
    """The first two cells of a row: monotonic seconds as local time of ISO 8601 with its offset, and as seconds
    since the first row, both to the millisecond.  Quick for times in order."""

    def __init__(self, wall_offset_s: float, *, first_s: float = 0.0) -> None:
        self._offset_s = wall_offset_s
        self._first_s = first_s
        self._second: int | None = None
        self._head = self._zone = ""

    def at(self, time_s: float) -> str:
        second, millisecond = divmod(round((time_s + self._offset_s) * 1000), 1000)
        if second != self._second:
            text = datetime.fromtimestamp(second).astimezone().isoformat()
            self._second, self._head, self._zone = second, text[:19], text[19:]
        return f"{self._head}.{millisecond:03d}{self._zone},{time_s - self._first_s:.3f}"


def write_atomically(path: Path, parts: Iterable[bytes], *, between: Callable[[], None] = lambda: None) -> None:
    """Write a file that is there as a whole or not at all; ``between`` is called after each part and may raise.

    Raises OSError where it cannot be written.  Whatever stops it, what was there before stays.
    """
    draft = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with draft.open("wb") as file:
            for part in parts:
                file.write(part)
                between()
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise


class Saving:
    """One file being written in a thread of its own, so that the window goes on.

    Not a daemon: a window that closes meanwhile lets the file be finished.
    """

    def __init__(self, path: Path, parts: Callable[[], Iterable[bytes]], count: int = 1) -> None:
        self.path = path
        self.error: Exception | None = None
        self._parts, self._count = parts, max(1, count)
        self._written = 0
        self._is_cancelled = False
        self._thread = threading.Thread(target=self._write, name="dps-s save", daemon=False)
        self._thread.start()

    @property
    def is_done(self) -> bool:
        """It ended, well or not; ``error`` tells."""
        return not self._thread.is_alive()

    @property
    def progress(self) -> float:
        """From 0 to 1."""
        return min(1.0, self._written / self._count)

    def cancel(self) -> None:
        """Stop at the next part, within 0.1 s."""
        self._is_cancelled = True

    def wait(self, timeout_s: float) -> bool:
        """Whether it ended within the time."""
        self._thread.join(timeout_s)
        return self.is_done

    def _write(self) -> None:
        try:
            write_atomically(self.path, self._parts(), between=self._count_part)
        except Exception as error:  # noqa: BLE001  said in the window; a thread has nobody else to tell
            self.error = error

    def _count_part(self) -> None:
        self._written += 1
        if self._is_cancelled:
            raise Cancelled
