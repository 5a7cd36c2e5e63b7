"""Exports a recording for other programs."""

from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from pathlib import Path
from typing import NamedTuple

from app.recordings.excerpt import csv_parts, part_count
from app.recordings.library import RecordingEntry
from app.recordings.recording import open_recording
from app.system.files import whole_file
from app.text.messages import UserMessage

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
