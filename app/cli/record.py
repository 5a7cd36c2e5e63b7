"""`dps-s record FILE`: records a session into .mcap or .csv, until Ctrl-C.

The session is kept among the recordings, as the window does, and exported at its end, also to standard output: nothing
is lost if the file cannot be written. Where nothing can be recorded it ends at once. An end of a conversation is a mark
in it, and the next one is polled. Exit code 0; 3 if the port was lost, or nobody answered for five seconds, with what
came until then; 4 if the file could not be written or is incomplete, as after a day, when the next recording begins.
"""

import argparse
import os
import shutil
import tempfile
from contextlib import suppress
from pathlib import Path

from app.cli.recordings import STANDARD_OUTPUT, ExportJson, add_export, export, refuse_unwritable
from app.recordings.library import RecordingEntry, RecordingLibrary, entry_of
from app.recordings.recorder import Recorder
from app.terminal import console
from app.terminal.arguments import add, add_port, add_seconds
from app.terminal.interruption import signals_noted
from app.terminal.streaming import Watching
from app.text.i18n import tr
from app.text.messages import UserError, join_sentences

SETTLE_LIMIT_S = 10.0  # how long writing the rest may take at the end


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_port(parser)
    add_seconds(parser)
    add_export(parser)
    add(parser, "--json")


def run(args: argparse.Namespace) -> int:
    refuse_unwritable(args)
    watching = Watching(args.port, args.baud, args.seconds, reads_all=True)
    library = _library()
    recorder = Recorder(library)
    with signals_noted():
        try:
            entries = [entry_of(path) for path in _record(watching, recorder)]
        finally:
            recorder.stop(SETTLE_LIMIT_S)
        if recorder.trouble is not None:
            console.notify(recorder.trouble.translated())
        if recorder.dropped:
            console.notify(tr("The disk was too slow. Not recorded: {count}.", count=recorder.dropped))
        if not entries:
            console.notify(tr("Nothing was recorded."))
        is_whole = len(entries) == 1 and not recorder.dropped and recorder.trouble is None
        is_whole = _write_file(entries, args, is_whole=is_whole)
    if is_whole and library.folder != RecordingLibrary().folder:
        shutil.rmtree(library.folder, ignore_errors=True)
    if watching.trouble is not None:
        console.notify(watching.trouble)
        return console.NO_LINK
    return console.SUCCESS if is_whole else console.PARTIAL


def _library() -> RecordingLibrary:
    """This user's or, where nothing can be kept there, a folder of its own, which goes once the file is written."""
    library = RecordingLibrary()
    with suppress(OSError):
        library.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        if os.access(library.folder, os.W_OK):
            return library
    return RecordingLibrary(Path(tempfile.mkdtemp(prefix="dps-s-")))


def _record(watching: Watching, recorder: Recorder) -> list[Path]:
    """The recordings; more than one after a day."""
    paths: list[Path] = []
    for batch in watching:
        if not paths and not recorder.is_recording and recorder.trouble is None:
            recorder.begin(batch.connection.port, batch.connection.baud_rate)
        recorder.on_batch(batch)
        if recorder.path is not None and recorder.path not in paths:
            paths.append(recorder.path)
        if recorder.trouble is not None:
            watching.is_over = True  # nothing more is recorded: said now, not after the flight
    recorder.settle(SETTLE_LIMIT_S)
    if recorder.path is not None and recorder.path not in paths:
        paths.append(recorder.path)
    return paths


def _write_file(entries: list[RecordingEntry], args: argparse.Namespace, *, is_whole: bool) -> bool:
    """Write the first recording into the file, and name the others; whether everything is in it."""
    files: list[str] = []
    for entry in entries[:1]:
        try:
            is_whole &= export(entry, args)
            files += [] if args.file == STANDARD_OUTPUT else [str(args.file)]
        except UserError as error:
            is_whole = False
            console.notify(join_sentences((error.sentence, tr("It is kept as recording {name}.", name=_place(entry)))))
        if entry.is_simulated:
            console.note(tr("Simulated module"))
    for entry in entries[1:]:
        console.notify(tr("It is kept as recording {name}.", name=_place(entry)))
    if args.json:
        console.write_lines([console.as_json(ExportJson([entry.name for entry in entries], files, is_whole))])
    return is_whole


def _place(entry: RecordingEntry) -> str:
    """Its name, or where it is, if that is not among the recordings."""
    return entry.name if entry.path.parent == RecordingLibrary().folder else str(entry.path)
