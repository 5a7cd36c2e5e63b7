"""Exports a recording for other programs."""

from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from pathlib import Path

from app.recordings.excerpt import csv_parts, part_count
from app.recordings.library import RecordingEntry, part_path
from app.recordings.recording import Recording
from app.system.files import whole_file
from app.text.i18n import tr
from app.text.sentences import not_written

Progress = Callable[[float], None]
_BLOCK_BYTES = 1 << 20


class ExportCancelled(Exception):
    """The export was cancelled; the file is unchanged."""


def not_saved_text(path: Path, error: Exception) -> str:
    """Why the file was not written, in the language in use."""
    if isinstance(error, ExportCancelled):
        return tr("Cancelled.")
    return not_written(path, error)


def write_parts(
    path: Path,
    parts: Iterable[bytes],
    count: int,
    *,
    on_progress: Progress = lambda _share: None,
    is_cancelled: Callable[[], bool] = bool,
) -> None:
    """Writes a file atomically. `count`: about how many parts. Raises OSError, `ExportCancelled`."""
    with whole_file(path) as file:
        for number, part in enumerate(parts):
            if is_cancelled():
                raise ExportCancelled
            file.write(part)
            on_progress(min(1.0, (number + 1) / count))


def export_csv(
    recording: Recording,
    path: Path,
    *,
    appends: bool = False,
    on_progress: Progress = lambda _share: None,
    is_cancelled: Callable[[], bool] = bool,
) -> int:
    """Writes a CSV table and returns its number of rows. Raises OSError, `ExportCancelled`.

    `on_progress` gets 0 … 1 in the calling thread. `appends`: adds to the rows of an existing file.
    """
    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    parts = csv_parts(excerpt, wall_offset_s=recording.wall_offset_s)
    if appends and path.exists() and path.stat().st_size:
        next(parts)  # without a second head
        parts = chain((path.read_bytes(),), parts)
    write_parts(path, parts, part_count(excerpt), on_progress=on_progress, is_cancelled=is_cancelled)
    return excerpt.row_count


def export_session(
    entry: RecordingEntry,
    path: Path,
    *,
    on_progress: Progress = lambda _share: None,
    is_cancelled: Callable[[], bool] = bool,
) -> None:
    """Copies a session; the further parts of a long one beside the first. Raises OSError, `ExportCancelled`."""
    whole, done = max(1, entry.size_bytes), 0

    def blocks(part: Path) -> Iterator[bytes]:
        nonlocal done
        with part.open("rb") as file:
            while block := file.read(_BLOCK_BYTES):
                yield block
                done += len(block)
                on_progress(min(1.0, done / whole))

    for number, part in enumerate(entry.parts, start=1):
        write_parts(part_path(path, number), blocks(part), 1, is_cancelled=is_cancelled)
