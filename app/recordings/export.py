"""Exports a recording for other programs."""

from collections.abc import Callable, Iterable
from itertools import chain
from pathlib import Path

from app.captures.writer import FULL, MAX_FILE_BYTES, lines_of
from app.recordings.recording import Recording
from app.recordings.table import csv_parts, part_count
from app.system.files import whole_file
from app.text.i18n import tr
from app.text.sentences import not_written

Progress = Callable[[float], None]


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


def export_mcap(
    recording: Recording,
    path: Path,
    *,
    on_progress: Progress = lambda _share: None,
    is_cancelled: Callable[[], bool] = bool,
) -> int:
    """Writes MCAP and returns the number of messages. Raises OSError, `ExportCancelled`.

    `on_progress` gets 0 … 1 in the calling thread.
    """
    from app.recordings.mcap_file import write_mcap

    def report(share: float) -> None:
        if is_cancelled():
            raise ExportCancelled
        on_progress(min(1.0, share))

    with whole_file(path) as file:
        return write_mcap(recording, file, report=report)


def export_capture(
    recording: Recording, path: Path, *, appends: bool = False, on_progress: Progress = lambda _share: None
) -> tuple[int, bool]:
    """Writes a capture; returns the number of entries, and whether it was too long for all of them. Raises OSError.

    `appends`: adds another part to an existing capture.
    """
    expected = max(1, recording.line_bytes)
    before = path.read_bytes() if appends and path.exists() else b""
    count, written = 0, len(before)
    with whole_file(path) as file:
        file.write(before)
        bytes_on_line = chain.from_iterable(map(lines_of, recording.traffic()))
        for line in chain(recording.opening.capture_header.lines(), bytes_on_line):
            written += len(line) + 1
            if written > MAX_FILE_BYTES:
                file.write(f"{FULL}\n".encode())
                return count, True
            file.write(f"{line}\n".encode())
            count += not line.startswith("#")
            on_progress(min(1.0, (written - len(before)) / expected))
    return count, False
