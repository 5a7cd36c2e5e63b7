"""`dps-s record FILE`: records a session into .mcap or .csv.

The session is kept among the recordings, as the window does, and exported at its end, also to standard output: nothing
is lost if the file cannot be written. Where nothing can be recorded it ends at once. An end of a conversation is a mark
in it, and the next one is polled. Exit code 0; 3 if the port was lost, or nobody answered for five seconds, with what
came until then; 4 if the file could not be written or is incomplete.
"""

import argparse
from itertools import count
from pathlib import Path

from app.cli.recordings import ExportJson, add_export, export, refuse_unwritable
from app.recordings.library import RecordingLibrary, entry_of
from app.recordings.recorder import Recorder
from app.terminal import console
from app.terminal.arguments import STANDARD_OUTPUT, add_json, add_port, add_seconds
from app.terminal.interruption import signals_noted
from app.terminal.streaming import Watching, ends_in
from app.text.i18n import tr
from app.text.sentences import join_sentences, labelled
from app.text.user_error import UserError

SETTLE_LIMIT_S = 10.0  # how long writing the rest may take at the end


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_port(parser)
    add_seconds(parser)
    add_export(parser)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    refuse_unwritable(args)
    watching = Watching(args.port, args.baud, args.seconds, reads_all=True)
    recorder = Recorder(RecordingLibrary())
    with signals_noted():
        try:
            paths = _record(watching, recorder)
        finally:
            console.clear_progress()
            recorder.stop(SETTLE_LIMIT_S)
        if recorder.trouble is not None:
            console.notify(recorder.trouble.translated())
        if recorder.dropped:
            console.notify(tr("The disk was too slow. Not recorded: {count}.", count=recorder.dropped))
        if not paths:
            console.notify(tr("Nothing was recorded."))
        is_whole = bool(paths) and not recorder.dropped and recorder.trouble is None
        is_whole &= _write_files(paths, args, is_whole=is_whole)
    if watching.trouble is not None:
        console.notify(watching.trouble)
        return console.NO_LINK
    return console.SUCCESS if is_whole else console.PARTIAL


def _record(watching: Watching, recorder: Recorder) -> list[Path]:
    """The recordings; more than one after a day."""
    paths: list[Path] = []
    samples = 0
    for batch in watching:
        if not paths and not recorder.is_recording and recorder.trouble is None:
            recorder.begin(batch.connection.port, batch.connection.baud_rate)
        recorder.on_batch(batch)
        if recorder.path is not None and recorder.path not in paths:
            paths.append(recorder.path)
        if recorder.trouble is not None:
            watching.is_over = True  # nothing more is recorded: said now, not after the flight
        for end in ends_in(batch):
            console.notify(end)
        samples += len(batch.samples)
        console.show_progress(labelled(tr("Reports"), f"{samples} (Ctrl-C)"))
    recorder.settle(SETTLE_LIMIT_S)
    if recorder.path is not None and recorder.path not in paths:
        paths.append(recorder.path)
    return paths


def _write_files(paths: list[Path], args: argparse.Namespace, *, is_whole: bool) -> bool:
    """Write the file, or one for each day; whether they are complete."""
    written: list[str] = []
    entries = list(map(entry_of, paths))
    for number, entry in enumerate(entries):
        target = args.file if number == 0 else _free_beside(args.file)
        try:
            is_whole &= export(entry, target, appends=args.append and number == 0, is_told=not args.json)
        except UserError as error:
            is_whole = False
            console.notify(join_sentences((error.sentence, tr("It is kept as recording {name}.", name=entry.name))))
            continue
        if target != STANDARD_OUTPUT:
            written.append(str(target))
        if entry.is_simulated:
            console.note(tr("Simulated module"))
    if args.json:
        console.write_lines([console.as_json(ExportJson([entry.name for entry in entries], written, is_whole))])
    return is_whole


def _free_beside(path: Path) -> Path:
    if path == STANDARD_OUTPUT:
        return path
    paths = (path.with_name(f"{path.stem}-{number}{path.suffix}") for number in count(2))
    return next(other for other in paths if not other.exists())
