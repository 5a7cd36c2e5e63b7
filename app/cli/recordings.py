"""`dps-s recordings list | export | delete`: manages recorded sessions.

A recording is given by the name of its file, the beginning of that name, or "latest". Exit code 0 done; 1 it cannot be
read or is being recorded; 2 there is no such recording, the file exists, or --yes is missing; 4 the file cannot be
written, or damaged parts were left out.
"""

import argparse

from app.cli.results import DeletedJson, ExportJson, RecordingJson, RecordingsJson
from app.recordings.entry_texts import remarks, size_text, when_text
from app.recordings.library import RecordingEntry, RecordingLibrary
from app.terminal import console
from app.terminal.arguments import add_json, add_verbosity, add_yes
from app.terminal.export_file import add_export, export, refuse_unwritable
from app.text.durations import stopwatch
from app.text.i18n import tr
from app.text.sentences import error_text, join_names, labelled
from app.text.user_error import ErrorCode, UserError

LATEST = "latest"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    listed = commands.add_parser("list", help="list all recordings")
    add_json(listed)
    exported = commands.add_parser("export", help="write one to a file")
    _add_name(exported)
    add_export(exported)
    add_json(exported)
    deleted = commands.add_parser("delete", help="delete one permanently")
    _add_name(deleted)
    add_yes(deleted)
    add_json(deleted)
    runs = ((listed, run_list), (exported, run_export), (deleted, run_delete))
    for command, function in runs:
        add_verbosity(command)
        command.set_defaults(function=function)


def _add_name(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME", help="beginning of the recording's name, or latest")


def run(args: argparse.Namespace) -> int:
    code: int = args.function(args)
    return code


def run_list(args: argparse.Namespace) -> int:
    library = RecordingLibrary()
    entries = library.entries()
    if not entries and not args.json:
        console.note(tr("No recordings yet"))
        return console.SUCCESS
    head = (tr("Name"), tr("Started"), tr("Duration"), tr("Reports"), tr("Size"), tr("Port"), tr("Module"), "")
    answer = RecordingsJson(folder=str(library.folder), recordings=[json_of(entry) for entry in entries])
    console.emit(args, answer, console.columns([head, *map(_row, entries)]))
    return console.SUCCESS


def json_of(entry: RecordingEntry) -> RecordingJson:
    return RecordingJson(
        name=entry.name,
        started_at=entry.started_at.isoformat(),
        duration_s=round(entry.duration_s, 3),
        port=entry.port,
        baud_rate=entry.baud_rate,
        modules=list(entry.modules),
        samples=entry.sample_count,
        size_bytes=entry.size_bytes,
        kept=entry.is_pinned,
        running=entry.is_running,
        cut_off=entry.was_cut_off,
        triggered=entry.was_triggered,
        simulated=entry.is_simulated,
        readable=entry.trouble is None,
    )


def _row(entry: RecordingEntry) -> tuple[str, ...]:
    pinned = tr("pinned") if entry.is_pinned else ""
    return (
        entry.name,
        when_text(entry),
        stopwatch(round(entry.duration_s)),
        f"{entry.sample_count}",
        size_text(entry.size_bytes),
        entry.port,
        entry.module,
        join_names(filter(None, (remarks(entry), pinned))),
    )


def run_export(args: argparse.Namespace) -> int:
    entry = _recording(RecordingLibrary(), args.name)
    refuse_unwritable(args.file, appends=args.append, replaces=args.force, is_json=args.json)
    try:
        is_whole = export(entry, args.file, appends=args.append, is_told=not args.json)
    except console.Refused as error:
        console.notify(error.sentence)
        if args.json:
            answer = ExportJson(recordings=[entry.name], files=[], complete=False)
            console.write_lines([console.as_json(answer)])
        return console.PARTIAL
    except UserError as error:
        raise console.Refused(error.message, ErrorCode.UNREADABLE) from error
    if args.json:
        answer = ExportJson(recordings=[entry.name], files=[str(args.file)], complete=is_whole)
        console.write_lines([console.as_json(answer)])
    return console.SUCCESS if is_whole else console.PARTIAL


def run_delete(args: argparse.Namespace) -> int:
    library = RecordingLibrary()
    entry = _recording(library, args.name)
    if not args.yes:
        console.refuse_without("--yes")
    try:
        library.delete(entry)
    except (UserError, OSError) as error:
        raise console.Refused(labelled(entry.name, error_text(error)), ErrorCode.REFUSED) from error
    console.emit(args, DeletedJson(deleted=[entry.name]), [entry.name])
    return console.SUCCESS


def _recording(library: RecordingLibrary, name: str) -> RecordingEntry:
    """The recording of this name. Raises `Refused` if there is none, or several."""
    entries = library.entries()
    if name == LATEST and entries:
        return entries[0]
    similar = [entry for entry in entries if name and entry.name.startswith(name)]
    exact = [entry for entry in similar if entry.name == name]
    if len(exact or similar) == 1:
        return (exact or similar)[0]
    if not similar:
        raise console.Refused(tr("No recording is named “{name}”.", name=name))
    raise console.Refused(tr("{count} recordings begin with “{name}”.", count=len(similar), name=name))
