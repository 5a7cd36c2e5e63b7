"""`dps-s recordings list | export | restore | delete`: manages recorded sessions.

A recording is named by its folder's name, by the beginning of it, or by "latest". Exit code 0 done; 1 it cannot be read
or is being written; 2 there is no such recording, or --yes is missing; 4 the file cannot be written, or something of
the recording was damaged and is left out.
"""

import argparse
from typing import TYPE_CHECKING

from app.terminal.console import (
    DONE,
    PARTLY,
    SAID_NO,
    USED_WRONGLY,
    add_json_argument,
    as_json,
    note,
    say,
    table,
    write_lines,
)
from app.text.durations import stopwatch
from app.text.i18n import tr
from app.text.sentences import listed, reason_of

if TYPE_CHECKING:
    from app.recordings.library import RecordingEntry, RecordingLibrary

LATEST = "latest"


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    from app.terminal.export_file import FORMATS, export_path

    parser = subparsers.add_parser(
        "recordings",
        description=tr(
            "List, export, restore and delete the sessions that the window recorded. Nothing is opened or sent."
        ),
    )
    acts = parser.add_subparsers(title=tr("commands"), metavar="COMMAND", required=True)
    listing = acts.add_parser("list", help=tr("list them, the newest first"))
    add_json_argument(listing)
    listing.set_defaults(run=run_list)
    export = acts.add_parser("export", help=tr("write one as CSV, MCAP or capture"))
    _add_name(export)
    export.add_argument("file", type=export_path, metavar="FILE", help=tr(FORMATS))
    export.set_defaults(run=run_export)
    restoring = acts.add_parser("restore", help=tr("take one out of the trash and keep it"))
    _add_name(restoring)
    restoring.set_defaults(run=run_restore)
    deletion = acts.add_parser("delete", help=tr("delete one for good (asks for --yes)"))
    _add_name(deletion)
    deletion.add_argument("--yes", action="store_true", help=tr("really do it"))
    deletion.set_defaults(run=run_delete)


def _add_name(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME", help=tr("the name, the beginning of it, or latest"))


def run_list(args: argparse.Namespace) -> int:
    from app.recordings.library import RecordingLibrary

    library = RecordingLibrary()
    entries = (*library.entries(), *library.trashed())
    if args.json:
        write_lines([as_json({"folder": str(library.folder), "recordings": [json_of(one) for one in entries]})])
        return DONE
    if not entries:
        note(tr("No recordings yet. Every session is recorded automatically."))
        return DONE
    head = (tr("Name"), tr("Started"), tr("Duration"), tr("Reports"), tr("Size"), tr("Port"), tr("Module"), "")
    write_lines(table(head, [_row(one) for one in entries]))
    return DONE


def json_of(entry: "RecordingEntry") -> dict[str, object]:
    return {
        "name": entry.folder.name,
        "started_at": entry.started_at.isoformat(),
        "duration_s": round(entry.duration_s, 3),
        "port": entry.port,
        "baud_rate": entry.baud_rate,
        "module": entry.module or None,
        "samples": entry.sample_count,
        "size_bytes": entry.size_bytes,
        "part": entry.part,
        "kept": entry.is_kept,
        "running": entry.is_running,
        "cut_off": entry.was_cut_off,
        "simulated": entry.is_simulated,
        "readable": entry.trouble is None,
        "trashed": entry.is_trashed,
    }


def _row(entry: "RecordingEntry") -> tuple[str, ...]:
    return (
        entry.folder.name,
        f"{entry.started_at.astimezone():%Y-%m-%d %H:%M}",
        stopwatch(round(entry.duration_s)),
        f"{entry.sample_count}",
        f"{entry.size_bytes / 1e6:.1f} MB",
        entry.port,
        entry.module,
        _remarks(entry),
    )


def _remarks(entry: "RecordingEntry") -> str:
    if entry.trouble is not None:
        return entry.trouble
    remarks = (
        (entry.part > 1, tr("part {number}", number=entry.part)),
        (entry.is_simulated, tr("simulated")),
        (entry.is_kept, tr("pinned")),
        (entry.is_running, tr("being recorded")),
        (entry.was_cut_off, tr("cut off")),
        (entry.is_trashed, tr("in the trash")),
    )
    return listed(text for is_so, text in remarks if is_so)


def run_export(args: argparse.Namespace) -> int:
    from app.recordings.library import RecordingLibrary
    from app.recordings.recording import RecordingUnreadable
    from app.terminal.export_file import export_recording, not_written

    entry = _found(RecordingLibrary(), args.name)
    if entry is None:
        return USED_WRONGLY
    try:
        done = export_recording(entry.folder, args.file)
    except RecordingUnreadable as error:
        say(error.sentence)
        return SAID_NO
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        say(not_written(args.file, error))
        return PARTLY
    write_lines([tr("{count} rows written to {file}.", count=done.rows, file=args.file)])
    for sentence in done.missing:
        say(sentence)
    return PARTLY if done.missing else DONE


def run_restore(args: argparse.Namespace) -> int:
    from app.recordings.library import RecordingLibrary

    library = RecordingLibrary()
    entry = _found(library, args.name)
    if entry is None:
        return USED_WRONGLY
    name = entry.folder.name
    if not entry.is_trashed:
        say(tr("{name} is not in the trash.", name=name))
        return SAID_NO
    try:
        library.keep(entry, is_kept=True)
    except OSError as error:
        say(tr("{name} cannot be restored: {why}.", name=name, why=reason_of(error)))
        return SAID_NO
    write_lines([tr("{name} was restored.", name=name)])
    return DONE


def run_delete(args: argparse.Namespace) -> int:
    from app.recordings.library import RecordingInUse, RecordingLibrary

    library = RecordingLibrary()
    entry = _found(library, args.name)
    if entry is None:
        return USED_WRONGLY
    name = entry.folder.name
    if not args.yes:
        say(tr("Nothing was deleted. To do it, say dps-s recordings delete {name} --yes.", name=name))
        return USED_WRONGLY
    try:
        library.delete(entry)
    except RecordingInUse:
        say(tr("{name} is being recorded: close the port in the window first.", name=name))
        return SAID_NO
    except OSError as error:
        say(tr("{name} cannot be deleted: {why}.", name=name, why=reason_of(error)))
        return SAID_NO
    write_lines([tr("{name} was deleted.", name=name)])
    return DONE


def _found(library: "RecordingLibrary", name: str) -> "RecordingEntry | None":
    """The one recording that is meant; says why where there is none."""
    entries = (*library.entries(), *library.trashed())
    if name == LATEST and entries:
        return entries[0]
    found = [one for one in entries if name and one.folder.name.startswith(name)]
    exact = [one for one in found if one.folder.name == name]
    if len(exact or found) == 1:
        return (exact or found)[0]
    if found:
        say(tr("{count} recordings begin with “{name}”: say more of the name.", count=len(found), name=name))
    else:
        say(tr("There is no recording “{name}”: dps-s recordings list shows all.", name=name))
    return None
