"""`dps-s record FILE`: records a session into .mcap or .csv, until Ctrl-C.

The session is kept among the recordings, as the window does, and exported at its end, also to standard output: nothing
is lost if the file cannot be written. Where nothing can be recorded it ends at once. An end of a conversation is a mark
in it, and the next one is polled. Exit code 0; 3 if the port was lost, or nobody answered for five seconds, with what
came until then; 4 if the file could not be written or is incomplete, as after a day, when the next recording begins.
"""

import argparse

from app.cli import monitor
from app.cli.recordings import ExportJson, add_export, export, refuse_unwritable
from app.recordings.library import RecordingLibrary, entry_of
from app.recordings.recorder import Recorder
from app.terminal import console
from app.terminal.connection import LOST
from app.text.i18n import tr

SETTLE_LIMIT_S = 10.0  # how long writing the rest may take at the end


def add_arguments(parser: argparse.ArgumentParser) -> None:
    monitor.add_arguments(parser)
    add_export(parser)


def run(args: argparse.Namespace) -> int:
    refuse_unwritable(args)
    recorder = Recorder(RecordingLibrary(), args.port, args.baud or console.USUAL_RATE)
    lost: Exception | None = None
    try:
        # Where nothing more is recorded it ends: said now, not after the flight.
        monitor.watch_port(args, recorder.on_batch, goes_on=lambda: recorder.trouble is None)
    except LOST as error:
        lost = error
    finally:
        is_settled = recorder.stop(SETTLE_LIMIT_S)
    # The first one is written into the file; the others, after a day each, are named.
    entries = [entry_of(path) for path in recorder.paths]
    kept = [tr("It is kept as recording {name}.", name=entry.name) for entry in entries]
    if lost is not None and not entries:
        raise lost
    faults = kept[1:]
    if not is_settled:
        faults.append(tr("The disk is too slow: the end of the recording is not written yet."))
    if recorder.trouble is not None:
        faults.append(recorder.trouble.translated())
    if not entries:
        faults.append(tr("Nothing was recorded."))
    for fault in faults:
        console.notify(fault)
    answer = ExportJson([entry.name for entry in entries], [], not faults)
    if entries:
        exported = export(entries[0], args)
        answer.files, answer.complete = exported.files, answer.complete and exported.complete
        if not exported.complete:
            console.notify(kept[0])
        if entries[0].is_simulated:
            console.note(tr("Simulated module"))
    console.emit(args, answer, [])
    if lost is not None:
        raise lost
    return console.SUCCESS if answer.complete else console.PARTIAL
