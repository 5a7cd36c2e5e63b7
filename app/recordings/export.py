"""Exports a recording for other programs."""

from collections.abc import Callable, Iterable
from pathlib import Path

from app.recordings.recording import Recording
from app.recordings.table import csv_parts, part_count
from app.system.files import whole_file
from app.text.i18n import tr

Progress = Callable[[float], None]


class ExportCancelled(Exception):
    """Somebody stopped the writing; the file is as it was before."""


def not_saved_text(path: Path, error: Exception) -> str:
    """Why there is no such file, in the language in use."""
    if isinstance(error, ExportCancelled):
        return tr("Cancelled, nothing was saved.")
    why = getattr(error, "strerror", None) or error
    return tr("Not saved to {path}: {why}. Choose another folder.", path=path, why=why)


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
    on_progress: Progress = lambda _share: None,
    is_cancelled: Callable[[], bool] = bool,
) -> int:
    """The rows written, with the columns of the Live page's table. Raises OSError, `ExportCancelled`.

    `on_progress` gets 0 … 1, in the calling thread.
    """
    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    parts = csv_parts(excerpt, wall_offset_s=recording.wall_offset_s)
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
