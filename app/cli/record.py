"""`dps-s record FILE`: records a session into .mcap or .csv.

The session is kept among the recordings, as the window does, and exported at its end: nothing is lost if the file
cannot be written. On standard output the table is written as it comes. Where nothing can be recorded it ends at once.
What may be another module's is in another file; a table on standard output ends there. Exit code 0; 3 if the link was
lost, with what came until then; 4 if the file could not be written or is incomplete.
"""

import argparse
import math
from itertools import count
from pathlib import Path

import numpy as np

from app.cli.results import ExportJson
from app.engine.identity import READ_WITHIN_S
from app.engine.worker import Batch, Connection, PortState
from app.recordings.excerpt import Excerpt, csv_parts
from app.recordings.library import RecordingLibrary, entry_of
from app.recordings.markers import MarkerTracker
from app.recordings.recorder import Recorder
from app.recordings.reports import ACTIVE, TRIGGERED
from app.recordings.writer import POLLED
from app.samples.ring_buffers import Window
from app.terminal import console
from app.terminal.arguments import add_json, add_port, add_seconds
from app.terminal.connection import Conversation
from app.terminal.export_file import STANDARD_OUTPUT, add_export, export, refuse_unwritable, write_table
from app.terminal.streaming import SameModule, StreamSpan, stream
from app.text.i18n import tr
from app.text.sentences import join_sentences, labelled
from app.text.user_error import UserError
from protocol.events import Event, Received
from protocol.messages import Status

SETTLE_LIMIT_S = 10.0
"""How long writing the rest may take at the end."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_port(parser)
    add_seconds(parser)
    add_export(parser)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    refuse_unwritable(args.file, appends=args.append, replaces=args.force, is_json=args.json)
    span = StreamSpan(args.seconds)
    session = RecordedSession(Recorder(RecordingLibrary()), span, LiveTable() if args.file == STANDARD_OUTPUT else None)
    try:
        trouble = stream(args.port, args.baud, span, on_begin=session.begin, on_batch=session.on_batch,
                         on_turn=session.on_turn, reads_all=True)  # fmt: skip
    finally:
        session.close()
    is_whole = write_files(session, args)
    if trouble is not None:
        console.notify(trouble)
        return console.NO_LINK
    return console.SUCCESS if is_whole else console.PARTIAL


class LiveTable:
    """Writes the table of a recording to standard output while it is made: what `export` writes of it afterwards."""

    def __init__(self) -> None:
        self._tracker, self._polled_s = MarkerTracker(), dict.fromkeys(POLLED, -math.inf)
        self._news: list[Excerpt] = []
        self._path: Path | None = None
        self._first_s = 0.0

    def on_batch(self, batch: Batch) -> None:
        markers, samples = tuple(self._tracker.on_batch(batch)), batch.samples
        times = np.array([sample.at for sample in samples])
        tilt, acceleration = (np.array([sample[column] for sample in samples], np.float32) for column in (1, 2))
        flags = [TRIGGERED * sample.triggered | ACTIVE * sample.active for sample in samples]
        cell, light = (self._reading(batch, key) for key in POLLED)
        news = Excerpt(-math.inf, Window(times, tilt), Window(times, acceleration), np.array(flags, np.uint8),
                       cell, light, markers)  # fmt: skip
        self._news += [news] if news.row_count else []

    def write(self, path: Path | None, wall_offset_s: float) -> None:
        """What came since the last call, once its recording has begun."""
        if path is None or not self._news:
            return
        is_first = self._path is None
        if path != self._path:  # also after a sleep or a jump of the clock
            self._path, self._first_s = path, min(news.first_s for news in self._news)
        for news in self._news:
            head, *rows = csv_parts(news, wall_offset_s=wall_offset_s, first_s=self._first_s)
            write_table([head, *rows] if is_first else rows)
            is_first = False
        self._news = []

    def _reading(self, batch: Batch, key: str) -> Window:
        known = batch.device.values.get(key)
        is_new = known is not None and not known.is_stale and known.at > self._polled_s[key]
        if known is None or not is_new or batch.connection.state is not PortState.OPEN:
            return Window(np.empty(0), np.empty(0, np.float32))
        self._polled_s[key] = known.at
        return Window(np.array([known.at]), np.array([known.value], np.float32))


class RecordedSession:
    """A recorder between `begin` and `close`."""

    def __init__(self, recorder: Recorder, span: StreamSpan, table: LiveTable | None) -> None:
        self._recorder, self._span, self._table = recorder, span, table
        self._samples = 0
        self.paths: list[Path] = []
        """More than one after another module, a sleep or a jump of the clock."""
        self._same = SameModule()
        self._held: list[Batch] = []
        """What came since a restart or a silence, until it is known whose it is or the recording ends."""
        self._has_ended = False
        """Before its end: another module may answer."""

    def begin(self, conversation: Conversation) -> None:
        connection = conversation.connection
        self._recorder.begin(connection.port, connection.baud_rate)

    def on_batch(self, batch: Batch) -> None:
        another = self._same.contradiction(batch.device)
        if not self._recorder.is_recording:
            return
        if another is not None:
            console.notify(another)
            self._begin_another(batch.connection)
        inside = tuple(sample for sample in batch.samples if self._span.holds(sample.at))
        unwanted = {sample.at for sample in batch.samples[len(inside) :]}
        events = tuple(event for event in batch.events if not (_is_report(event) and event.at in unwanted))
        self._held.append(batch._replace(samples=inside, events=events))
        first = self._held[0]
        is_answered = any(isinstance(event, Received) for event in first.events)  # a silence is nobody's
        if not (self._same.is_in_doubt and is_answered) or batch.at - first.at > READ_WITHIN_S:
            self._record_held()

    def _begin_another(self, connection: Connection) -> None:
        self._has_ended = self._span.is_over = self._table is not None
        self._recorder.settle(SETTLE_LIMIT_S)  # else its file may not be there yet
        self._note_path()
        if self._has_ended:
            self._recorder.end()
        else:
            self._recorder.begin(connection.port, connection.baud_rate)

    def _record_held(self) -> None:
        held, self._held = self._held, []
        for batch in held if self._recorder.is_recording else ():
            self._samples += len(batch.samples)
            self._recorder.on_batch(batch)
            if self._table is not None:
                self._table.on_batch(batch)

    def on_turn(self, _conversation: Conversation) -> None:
        self._note_path()
        if self._recorder.trouble is not None:
            self._span.is_over = True  # nothing more is recorded: said now, not after the flight
        console.show_progress(labelled(tr("Reports"), f"{self._samples} (Ctrl-C)"))

    def close(self) -> None:
        """Wait until everything is on disk; print what is missing. Idempotent."""
        console.clear_progress()
        self._record_held()
        self._recorder.settle(SETTLE_LIMIT_S)
        try:
            self._note_path()
            if self._recorder.trouble is not None:
                console.notify(self._recorder.trouble.translated())
            if self._recorder.dropped:
                console.notify(tr("The disk was too slow. Not recorded: {count}.", count=self._recorder.dropped))
        finally:
            self._recorder.stop(SETTLE_LIMIT_S)

    @property
    def is_whole(self) -> bool:
        return not (self._recorder.dropped or self._has_ended) and self._recorder.trouble is None

    def _note_path(self) -> None:
        path = self._recorder.path
        if path is not None and path not in self.paths:
            self.paths.append(path)
        if self._table is not None:
            self._table.write(path, self._recorder.wall_offset_s)


def _is_report(event: Event) -> bool:
    return isinstance(event, Received) and isinstance(event.message, Status)


def write_files(session: RecordedSession, args: argparse.Namespace) -> bool:
    """Write the file, or one for each session; whether they are complete."""
    path: Path = args.file
    is_whole = session.is_whole and bool(session.paths)
    names: list[str] = []
    written: list[str] = []
    if not session.paths:
        console.notify(tr("Nothing was recorded."))
    for number, recorded in enumerate(session.paths, start=1):
        entry = entry_of(recorded)
        names.append(entry.name)
        target = path if number == 1 else _free_beside(path)
        try:
            if path != STANDARD_OUTPUT:  # else it is written
                is_whole &= export(entry, target, appends=args.append and number == 1, is_told=not args.json)
                written.append(str(target))
        except UserError as error:
            is_whole = False
            console.notify(join_sentences((error.sentence, tr("It is kept as recording {name}.", name=entry.name))))
            continue
        if entry.is_simulated:
            console.note(tr("Simulated module"))
    if args.json:
        console.write_lines([console.as_json(ExportJson(recordings=names, files=written, complete=is_whole))])
    return is_whole


def _free_beside(path: Path) -> Path:
    paths = (path.with_name(f"{path.stem}-{number}{path.suffix}") for number in count(2))
    return next(other for other in paths if not other.exists())
