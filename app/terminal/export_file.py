"""Exports recordings to files, in the format of their suffix."""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from app.terminal.arguments import expected
from app.terminal.console import clear_progress, notify, show_progress, write, write_lines
from app.text.i18n import tr
from app.text.sentences import not_written

if TYPE_CHECKING:
    from app.recordings.library import RecordingEntry
    from app.recordings.recording import Recording

CSV, MCAP = ".csv", ".mcap"
ENDINGS = (MCAP, CSV)
STANDARD_OUTPUT = Path("-")
"""Gets the CSV table."""


class Exported(NamedTuple):
    """`missing`: sentences about what the file lacks."""

    rows: int
    missing: tuple[str, ...]


def export_path(text: str) -> Path:
    """For argparse."""
    path = Path(text)
    if path.suffix.lower() in ENDINGS or path == STANDARD_OUTPUT:
        return path
    raise expected("|".join((*ENDINGS, str(STANDARD_OUTPUT))))


def unwritable_reason(path: Path, *, appends: bool, replaces: bool) -> str | None:
    """Checks the file before anything is recorded; a sentence if it cannot be used."""
    from app.recordings.table import HEAD

    if path == STANDARD_OUTPUT:
        return None
    if not path.parent.is_dir():
        return tr("There is no folder {folder}.", folder=path.parent)
    if appends and path.suffix.lower() == MCAP:
        return tr("expected {expected}", expected=CSV)
    if not path.exists() or replaces:
        return None
    if not appends:
        return tr("{file} exists: use --append or --force.", file=path)
    try:
        with path.open("rb") as file:
            first = file.readline(1000).removeprefix(b"\xef\xbb\xbf").strip().decode("utf-8", "replace")
    except OSError as error:
        return not_written(path, error)
    if first not in ("", HEAD):
        return tr("{file} has other columns or is no recording.", file=path)
    return None


def export_and_report(entry: "RecordingEntry", path: Path, *, appends: bool = False) -> Exported | None:
    """Export a recording, and print the outcome; None if the file cannot be written. Raises `UserError`."""
    try:
        done = export_recording(entry, path, appends=appends)
    except (OSError, ValueError) as error:
        notify(not_written(path, error))
        return None
    if path != STANDARD_OUTPUT:
        write_lines([tr("Rows written to {file}: {count}.", count=done.rows, file=path)])
    for sentence in done.missing:
        notify(sentence)
    return done


def export_recording(entry: "RecordingEntry", path: Path, *, appends: bool = False) -> Exported:
    """Raises OSError, ValueError, `UserError`; the file is unchanged then."""
    from app.recordings.export import export_csv, export_session
    from app.recordings.recording import open_recording

    missing: list[str] = []
    try:
        with open_recording(entry) as recording:
            if path == STANDARD_OUTPUT:
                rows = _write_csv(recording, has_head=not appends)
            elif path.suffix.lower() == MCAP:
                export_session(entry, path, on_progress=_show)
                rows = len(recording.tilt)
            else:
                rows = export_csv(recording, path, appends=appends, on_progress=_show)
            if recording.damage is not None:
                missing.append(recording.damage.translated())
    finally:
        clear_progress()
    return Exported(rows, tuple(missing))


def _write_csv(recording: "Recording", *, has_head: bool) -> int:
    """Write the table to standard output; returns the number of rows."""
    from app.recordings.table import csv_parts

    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    for number, part in enumerate(csv_parts(excerpt, wall_offset_s=recording.wall_offset_s)):
        if number or has_head:
            write(part.decode().replace("\r\n", "\n"))  # standard output ends lines as the system does
    return excerpt.row_count


def _show(share: float) -> None:
    show_progress(f"{share:.0%}")
