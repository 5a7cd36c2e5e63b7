"""Exports a recording for other programs."""

from collections.abc import Callable
from pathlib import Path

from app.recordings.recording import Recording
from app.recordings.table import csv_parts, part_count
from app.system.files import whole_file

Progress = Callable[[float], None]


class ExportCancelled(Exception):
    """Somebody stopped the writing; the file is as it was before."""


def export_csv(
    recording: Recording,
    path: Path,
    *,
    on_progress: Progress = lambda _share: None,
    is_cancelled: Callable[[], bool] = bool,
) -> int:
    """The rows written, with the columns of the Live page's table. Raises OSError, `ExportCancelled`.

    `on_progress` gets 0 … 1, in the calling thread.
    """
    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    count = part_count(excerpt)
    with whole_file(path) as file:
        for number, part in enumerate(csv_parts(excerpt, wall_offset_s=recording.wall_offset_s)):
            if is_cancelled():
                raise ExportCancelled
            file.write(part)
            on_progress(min(1.0, (number + 1) / count))
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
