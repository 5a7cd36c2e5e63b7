"""`dps-s record FILE`: records a session into .mcap or .csv.

The session is kept among the recordings, as the window does, and exported at its end: nothing is lost if the file
cannot be written. Where nothing can be recorded it ends at once. Exit code 0; 3 if the link was lost, with what came
until then; 4 if the file could not be written or is incomplete.
"""

import argparse
from dataclasses import replace
from pathlib import Path

from app.engine.worker import Batch
from app.recordings.library import RecordingLibrary, entry_of
from app.recordings.recorder import Recorder
from app.terminal import console
from app.terminal.connection import Conversation
from app.terminal.export_file import STANDARD_OUTPUT, export, refuse_unwritable
from app.terminal.streaming import StreamSpan, stream
from app.text.i18n import tr
from app.text.sentences import join_sentences, labelled
from app.text.user_error import UserError
from protocol.events import Event, Received
from protocol.messages import Status

SETTLE_LIMIT_S = 10.0
"""How long writing the rest may take at the end."""


def run(args: argparse.Namespace) -> int:
    refuse_unwritable(args.file, appends=args.append, replaces=args.force)
    span = StreamSpan(args.seconds)
    session = RecordedSession(Recorder(RecordingLibrary()), span)
    try:
        trouble = stream(args.port, args.baud, span, on_begin=session.begin, on_batch=session.on_batch,
                         on_turn=session.on_turn, reads_all=True)  # fmt: skip
    finally:
        session.close()
    is_whole = write_files(session, args.file, appends=args.append)
    if trouble is not None:
        console.notify(trouble)
        return console.NO_LINK
    return console.SUCCESS if is_whole else console.PARTIAL


class RecordedSession:
    """A recorder between `begin` and `close`."""

    def __init__(self, recorder: Recorder, span: StreamSpan) -> None:
        self._recorder, self._span = recorder, span
        self._samples = 0
        self.paths: list[Path] = []
        """More than one after a sleep or a jump of the clock."""

    def begin(self, conversation: Conversation) -> None:
        connection = conversation.connection
        self._recorder.begin(connection.port, connection.baud_rate)

    def on_batch(self, batch: Batch) -> None:
        if self._recorder.is_recording:
            wanted = tuple(sample for sample in batch.samples if self._span.holds(sample.at))
            self._samples += len(wanted)
            unwanted = {sample.at for sample in batch.samples[len(wanted) :]}
            events = tuple(event for event in batch.events if not (_is_report(event) and event.at in unwanted))
            self._recorder.on_batch(replace(batch, samples=wanted, events=events))

    def on_turn(self, _conversation: Conversation) -> None:
        self._note_path()
        if self._recorder.trouble is not None:
            self._span.is_over = True  # nothing more is recorded: said now, not after the flight
        console.show_progress(labelled(tr("Reports"), f"{self._samples} (Ctrl-C)"))

    def close(self) -> None:
        """Wait until everything is on disk; print what is missing. Idempotent."""
        console.clear_progress()
        self._recorder.settle(SETTLE_LIMIT_S)
        self._note_path()
        if self._recorder.trouble is not None:
            console.notify(self._recorder.trouble.translated())
        if self._recorder.dropped:
            console.notify(tr("The disk was too slow. Reports missing: {count}.",
                   count=self._recorder.dropped))  # fmt: skip
        self._recorder.stop(SETTLE_LIMIT_S)

    @property
    def is_whole(self) -> bool:
        return not self._recorder.dropped and self._recorder.trouble is None

    def _note_path(self) -> None:
        path = self._recorder.path
        if path is not None and path not in self.paths:
            self.paths.append(path)


def _is_report(event: Event) -> bool:
    return isinstance(event, Received) and isinstance(event.message, Status)


def write_files(session: RecordedSession, path: Path, *, appends: bool) -> bool:
    """Write the file, or one for each session; whether they are complete."""
    is_whole = session.is_whole and bool(session.paths)
    if not session.paths:
        console.notify(tr("Nothing was recorded."))
    for number, recorded in enumerate(session.paths, start=1):
        entry = entry_of(recorded)
        is_output = path == STANDARD_OUTPUT
        target = path if number == 1 or is_output else path.with_name(f"{path.stem}-{number}{path.suffix}")
        try:
            is_whole &= export(entry, target, appends=appends if number == 1 else is_output)
        except UserError as error:
            is_whole = False
            console.notify(join_sentences((error.sentence, tr("It is kept as recording {name}.", name=entry.name))))
            continue
        if entry.is_simulated:
            console.note(tr("Simulated module"))
    return is_whole
