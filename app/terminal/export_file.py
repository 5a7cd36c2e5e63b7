"""Exports recordings to files, in the format of their suffix."""

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from app.terminal.arguments import add_file, expected
from app.terminal.console import Refused, clear_progress, notify, show_progress, write, write_lines
from app.text.i18n import tr
from app.text.sentences import not_written, saved_text
from app.text.user_error import ErrorCode

if TYPE_CHECKING:
    from app.recordings.library import RecordingEntry
    from app.text.messages import UserMessage

CSV, MCAP = ".csv", ".mcap"
ENDINGS = (MCAP, CSV)
STANDARD_OUTPUT = Path("-")
"""Gets the CSV table."""


def export_path(text: str) -> Path:
    """For argparse."""
    path = Path(text)
    if path.suffix.lower() in ENDINGS or path == STANDARD_OUTPUT:
        return path
    raise expected(", ".join((*ENDINGS, str(STANDARD_OUTPUT))))


def add_export(parser: argparse.ArgumentParser) -> None:
    """The file, and what becomes of one that is there."""
    existing = parser.add_mutually_exclusive_group()
    existing.add_argument("--append", action="store_true", help="add to the file (only .csv)")
    existing.add_argument("--force", action="store_true", help="replace the file")
    add_file(parser, "file", type=export_path, metavar="FILE", help=".mcap, .csv, or - for a table on standard output")


def refuse_unwritable(path: Path, *, appends: bool, replaces: bool, is_json: bool = False) -> None:
    """Checks the file before anything is recorded. Raises `Refused`."""
    from app.recordings.excerpt import HEAD

    if path == STANDARD_OUTPUT:
        if is_json:  # there is one standard output
            raise Refused(tr("expected {expected}", expected="FILE --json | -"))
        return
    if not path.parent.is_dir():
        raise Refused(tr("There is no folder {folder}.", folder=path.parent))
    if appends and path.suffix.lower() == MCAP:
        raise Refused(tr("expected {expected}", expected=CSV))
    if not path.exists() or replaces:
        return
    if not appends:
        raise Refused(tr("{file} exists: use {options}.", file=path, options="--append, --force"))
    try:
        with path.open("rb") as file:
            first = file.readline(1000).removeprefix(b"\xef\xbb\xbf").strip().decode("utf-8", "replace")
    except OSError as error:
        raise Refused(not_written(path, error)) from error
    if first != HEAD and path.stat().st_size:
        raise Refused(tr("{file} has other columns or is no recording.", file=path))


def export(entry: "RecordingEntry", path: Path, *, appends: bool = False, is_told: bool = True) -> bool:
    """Export a recording, and print what came of it if `is_told`; whether it is whole. Raises `Refused` where the file
    cannot be written, else `UserError`; the file is unchanged then."""
    from app.recordings.export import export as write_file

    if path == STANDARD_OUTPUT:
        damage = _write_out(entry)
    else:
        try:
            rows, damage = write_file(entry, path, is_table=path.suffix.lower() != MCAP, appends=appends,
                                      on_progress=lambda share: show_progress(f"{share:.0%}"))  # fmt: skip
        except (OSError, ValueError) as error:
            raise Refused(not_written(path, error), ErrorCode.REFUSED) from error
        finally:
            clear_progress()
        if is_told:
            write_lines([saved_text(path, rows)])
    if damage is not None:
        notify(damage.translated())
    return damage is None


def _write_out(entry: "RecordingEntry") -> "UserMessage | None":
    """Write the table to standard output; returns what is missing in it."""
    from app.recordings.excerpt import csv_parts
    from app.recordings.recording import open_recording

    recording = open_recording(entry)
    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    write_table(csv_parts(excerpt, wall_offset_s=recording.wall_offset_s))
    return recording.damage


def write_table(parts: Iterable[bytes]) -> None:
    for part in parts:
        write(part.decode().replace("\r\n", "\n"))  # standard output ends lines as the system does
