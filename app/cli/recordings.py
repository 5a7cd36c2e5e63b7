"""`dps-s recordings list | export | delete`: manages recorded sessions.

A recording is given by the name of its file, or "latest". Exit code 0 done; 1 it is being recorded; 2 there is no such
recording, it cannot be read, the file exists, or --yes is missing; 4 the file cannot be written, or what is damaged was
left out.
"""

import argparse
from pathlib import Path

from msgspec import field

from app.recordings.excerpt import HEAD, csv_parts
from app.recordings.library import RecordingEntry, RecordingLibrary, remarks, when_text
from app.recordings.recording import export as write_file
from app.recordings.recording import open_recording
from app.terminal import console
from app.terminal.results import Count, Result, Time
from app.text.i18n import tr
from app.text.messages import ErrorCode, UserError, error_text, labelled, not_written, saved_text, stopwatch

CSV, MCAP = ".csv", ".mcap"
STANDARD_OUTPUT = Path("-")


class RecordingJson(Result):
    name: str
    started_at: Time
    duration_s: float
    port: str
    baud_rate: Count
    modules: list[str]
    sample_count: Count = field(name="samples")
    size_bytes: Count
    is_running: bool = field(name="running")
    was_cut_off: bool = field(name="cut_off")
    was_triggered: bool = field(name="triggered")
    is_simulated: bool = field(name="simulated")
    readable: bool


class RecordingsJson(Result):
    folder: str
    recordings: list[RecordingJson]


class ExportJson(Result):
    """`complete`: whether the files hold all that was recorded."""

    recordings: list[str]
    files: list[str]
    complete: bool


class DeletedJson(Result):
    deleted: list[str]


def add_export(parser: argparse.ArgumentParser) -> None:
    """The file, and what becomes of one that is there; also of `dps-s record`."""
    existing = parser.add_mutually_exclusive_group()
    existing.add_argument("--append", action="store_true", help="add to the file (only .csv)")
    console.add_flags(existing, "--force")
    console.add_file(parser, "file", metavar="FILE", help=".mcap, .csv, or - for a table on standard output")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    console.add_command(commands, run_list, "list", "list all recordings")
    exported = console.add_command(commands, run_export, "export", "write one to a file")
    deleted = console.add_command(commands, run_delete, "delete", "delete one permanently")
    for command in (exported, deleted):
        command.add_argument("name", metavar="NAME", help="name of the recording, or latest")
    add_export(exported)
    console.add_flags(deleted, "--yes")


def run(args: argparse.Namespace) -> int:
    return int(args.function(args, RecordingLibrary()))


def run_list(args: argparse.Namespace, library: RecordingLibrary) -> int:
    entries = library.entries()
    rows = [(tr("Name"), tr("Started"), tr("Duration"), tr("Module"), "")]
    answer = RecordingsJson(str(library.folder), [])
    for entry in entries:
        started_at, duration_s = entry.started_at.isoformat(), round(entry.duration_s, 3)
        listed = RecordingJson.of(entry, started_at=started_at, duration_s=duration_s, readable=entry.trouble is None)
        answer.recordings.append(listed)
        duration = stopwatch(round(entry.duration_s))
        rows.append((entry.name, when_text(entry), duration, entry.module, remarks(entry)))
    if not entries:
        console.note(tr("No recordings yet"))
    return console.emit(args, answer, console.columns(rows) if entries else [])


def run_export(args: argparse.Namespace, library: RecordingLibrary) -> int:
    entry = _recording(library, args.name)
    refuse_unwritable(args)
    answer = export(entry, args)
    return console.emit(args, answer, [], console.SUCCESS if answer.complete else console.PARTIAL)


def run_delete(args: argparse.Namespace, library: RecordingLibrary) -> int:
    entry = _recording(library, args.name)
    console.require("--yes", is_given=args.yes)
    try:
        library.delete(entry)
    except (UserError, OSError) as error:
        raise console.Refused(labelled(entry.name, error_text(error)), ErrorCode.REFUSED) from error
    return console.emit(args, DeletedJson([entry.name]), [entry.name])


def _recording(library: RecordingLibrary, name: str) -> RecordingEntry:
    for entry in library.entries():  # the newest first
        if name in (entry.name, "latest"):
            return entry
    raise console.Refused(tr("No recording is named “{name}”.", name=name))


# Export, also of what `dps-s record` has recorded


def refuse_unwritable(args: argparse.Namespace) -> None:
    # Before anything is recorded. Raises `Refused`.
    path: Path = args.file
    if path == STANDARD_OUTPUT:
        if args.json:  # there is one standard output
            raise console.Refused(tr("expected {expected}", expected="FILE --json | -"))
        return
    if path.suffix.lower() not in (MCAP, CSV):
        raise console.Refused(tr("expected {expected}", expected=f"{MCAP}, {CSV}, {STANDARD_OUTPUT}"))
    if not path.parent.is_dir():
        raise console.Refused(tr("There is no folder {folder}.", folder=path.parent))
    if args.append and path.suffix.lower() == MCAP:
        raise console.Refused(tr("expected {expected}", expected=CSV))
    console.refuse_existing(path, is_forced=args.force or args.append)
    if args.append and path.exists():
        with path.open("rb") as file:
            first = file.readline(1000).removeprefix(b"\xef\xbb\xbf").strip().decode("utf-8", "replace")
        if first != HEAD and path.stat().st_size:
            raise console.Refused(tr("{file} has other columns or is no recording.", file=path))


def export(entry: RecordingEntry, args: argparse.Namespace) -> ExportJson:
    """Export a recording to the file that was named, and say what came of it. Where it cannot be written the file is
    unchanged. Raises `Refused` for a recording that cannot be read."""
    path: Path = args.file
    answer = ExportJson([entry.name], [], complete=False)
    try:
        if path == STANDARD_OUTPUT:
            recording = open_recording(entry)
            damage = recording.damage
            excerpt = recording.excerpt(recording.start_s, recording.end_s)
            for part in csv_parts(excerpt, wall_offset_s=recording.wall_offset_s):
                console.write(part.decode().replace("\r\n", "\n"))  # standard output ends lines as the system does
        else:
            rows, damage = write_file(entry, path, appends=args.append)
            answer.files.append(str(path))
            if not args.json:
                console.write_lines([saved_text(path, rows)])
    except UserError as error:
        raise console.Refused(error.message, ErrorCode.UNREADABLE) from error
    except (OSError, ValueError) as error:
        console.notify(not_written(path, error))
        return answer
    if damage is not None:
        console.notify(damage.translated())
    answer.complete = damage is None
    return answer
