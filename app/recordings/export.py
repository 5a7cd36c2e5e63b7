"""Exports a recording for other programs."""

from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from pathlib import Path

from app.captures.entries import CaptureEntry
from app.captures.writer import FULL, LONGEST_FILE_BYTES, Header, lines_of
from app.recordings.recording import Recording
from app.recordings.table import csv_parts, part_count
from app.system.files import whole_file
from app.text.i18n import tr
from app.text.sentences import reason_of

Progress = Callable[[float], None]


class ExportCancelled(Exception):
    """Somebody stopped the writing; the file is as it was before."""


def not_saved_text(path: Path, error: Exception) -> str:
    """Why there is no such file, in the language in use."""
    if isinstance(error, ExportCancelled):
        return tr("Cancelled.")
    return tr("{file} cannot be written: {why}.", file=path, why=reason_of(error))


def write_parts(
    path: Path,
    parts: Iterable[bytes],
    count: int,
    *,
    on_progress: Progress = lambda _share: None,
    is_cancelled: Callable[[], bool] = bool,
) -> None:
    """A file that is there whole or not at all. `count`: so many parts, or about. Raises OSError, `ExportCancelled`."""
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
    """The rows written, with the columns of the Live page's table. Raises OSError, `ExportCancelled`.

    `on_progress` gets 0 … 1, in the calling thread. `appends`: behind the rows that the file has already.
    """
    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    parts = csv_parts(excerpt, wall_offset_s=recording.wall_offset_s)
    if appends and path.exists() and path.stat().st_size:
        next(parts)  # the head is there
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
    """The messages written. Raises OSError, `ExportCancelled`. `on_progress` gets 0 … 1, in the calling thread."""
    from app.recordings.mcap_file import write_mcap

    def look(share: float) -> None:
        if is_cancelled():
            raise ExportCancelled
        on_progress(min(1.0, share))

    with whole_file(path) as file:
        return write_mcap(recording, file, look=look)


def export_capture(
    recording: Recording, path: Path, *, appends: bool = False, on_progress: Progress = lambda _share: None
) -> tuple[int, bool]:
    """The entries written, and whether not all fitted into a capture. Raises OSError.

    `appends`: as another part of the capture that the file holds already.
    """
    opening = recording.opening
    header = Header(
        program=opening.program,
        port=opening.port,
        baud_rate=opening.baud_rate,
        started=opening.started_at.isoformat(),
    )
    expected = max(1, recording.line_bytes)
    before = path.read_bytes() if appends and path.exists() else b""
    count, written = 0, len(before)
    with whole_file(path) as file:
        file.write(before)
        for line in chain(header.lines(), _capture_lines(recording)):
            written += len(line) + 1
            if written > LONGEST_FILE_BYTES:
                file.write(f"{FULL}\n".encode())
                return count, True
            file.write(f"{line}\n".encode())
            count += not line.startswith("#")
            on_progress(min(1.0, (written - len(before)) / expected))
    return count, False


def _capture_lines(recording: Recording) -> Iterator[str]:
    for one in recording.traffic():
        yield from lines_of(CaptureEntry(one.time_s - recording.opening.start_s, one.way, one.raw))
