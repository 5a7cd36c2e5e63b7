"""`dps-s record FILE`: records a session into .mcap or .csv, until Ctrl-C.

The session is kept among the recordings, as the window does, and exported at its end, also to standard output: nothing
is lost if the file cannot be written. Where nothing can be recorded it ends at once. An end of a conversation is a mark
in it, and the next one is polled. Exit code 0; 3 if the port was lost, or nobody answered for five seconds, with what
came until then; 4 if the file could not be written or is incomplete, as after a day, when the next recording begins.
"""

import argparse

from app.cli import monitor
from app.cli.recordings import STANDARD_OUTPUT, ExportJson, add_export, export, refuse_unwritable
from app.recordings.library import RecordingLibrary, entry_of
from app.recordings.recorder import Recorder
from app.terminal import console
from app.terminal.connection import LOST
from app.text.i18n import tr
from app.text.messages import UserError, join_sentences

SETTLE_LIMIT_S = 10.0  # how long writing the rest may take at the end


def add_arguments(parser: argparse.ArgumentParser) -> None:
    monitor.add_arguments(parser)
    add_export(parser)


def run(args: argparse.Namespace) -> int:
    refuse_unwritable(args)
    recorder: Recorder | None = None
    lost: Exception | None = None
    is_whole = True
    try:
        for batch in monitor.watched(args, reads_all=True):
            if recorder is None:
                recorder = Recorder(RecordingLibrary(), batch.connection.port, batch.connection.baud_rate)
            recorder.on_batch(batch)
            if recorder.trouble is not None:
                break  # nothing more is recorded: said now, not after the flight
    except LOST as error:
        lost = error
    finally:
        if recorder is not None and not recorder.stop(SETTLE_LIMIT_S):
            is_whole = False
            console.notify(tr("The disk is too slow: the end of the recording is not written yet."))
    # The first one is written into the file; the others, after a day each, are named.
    entries = [] if recorder is None else [entry_of(path) for path in recorder.paths]
    if lost is not None and not entries:
        raise lost
    is_whole &= len(entries) == 1
    if recorder is not None and recorder.trouble is not None:
        is_whole = False
        console.notify(recorder.trouble.translated())
    if recorder is not None and recorder.dropped:
        is_whole = False
        console.notify(tr("The disk was too slow. Not recorded: {count}.", count=recorder.dropped))
    if not entries:
        console.notify(tr("Nothing was recorded."))
    files: list[str] = []
    for entry in entries:
        kept = tr("It is kept as recording {name}.", name=entry.name)
        if entry is not entries[0]:
            console.notify(kept)
            continue
        try:
            is_whole &= export(entry, args)
            files += [] if args.file == STANDARD_OUTPUT else [str(args.file)]
        except UserError as error:
            is_whole = False
            console.notify(join_sentences((error.sentence, kept)))
        if entry.is_simulated:
            console.note(tr("Simulated module"))
    if args.json:
        console.emit(args, ExportJson([entry.name for entry in entries], files, is_whole), [])
    if lost is not None:
        raise lost
    return console.SUCCESS if is_whole else console.PARTIAL
