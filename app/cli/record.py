"""`dps-s record FILE`: records a session into .mcap or .csv.

The session is kept among the recordings, as the window does, and exported at its end: nothing is lost if the file
cannot be written. On standard output the table is written as it comes. Where nothing can be recorded it ends at once.
An end of a conversation is a mark in it, and the next one is polled. Exit code 0; 3 if the port was lost, or nobody
answered for five seconds, with what came until then; 4 if the file could not be written or is incomplete.
"""

import argparse
import math
from itertools import count
from pathlib import Path

import numpy as np

from app.cli.results import ExportJson
from app.engine.worker import Batch
from app.recordings.excerpt import ACTIVE, TRIGGERED, Excerpt, csv_parts
from app.recordings.library import RecordingLibrary, entry_of
from app.recordings.markers import MarkerTracker
from app.recordings.recorder import Recorder
from app.recordings.writer import POLLED
from app.samples.ring_buffers import Window
from app.terminal import console
from app.terminal.arguments import add_json, add_port, add_seconds
from app.terminal.connection import OpenPort
from app.terminal.export_file import STANDARD_OUTPUT, add_export, export, refuse_unwritable, write_table
from app.terminal.streaming import StreamSpan, marks_in, stream
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
    table = LiveTable() if args.file == STANDARD_OUTPUT else None
    session = RecordedSession(Recorder(RecordingLibrary()), span, table)
    try:
        trouble = stream(args.port, args.baud, span, on_batch=session.on_batch, on_turn=session.on_turn, reads_all=True)
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
        self._tracker = MarkerTracker()
        self._polled_s = dict.fromkeys(POLLED, -math.inf)
        self._news: list[Excerpt] = []
        self._first_s: float | None = None

    def on_batch(self, batch: Batch) -> None:
        samples = batch.samples
        times = np.array([sample.at for sample in samples])
        tilt = np.array([sample.tilt_deg for sample in samples], np.float32)
        acceleration = np.array([sample.acceleration_g for sample in samples], np.float32)
        flags = [TRIGGERED * sample.triggered | ACTIVE * sample.active for sample in samples]
        news = Excerpt(
            start_s=-math.inf,
            tilt=Window(times, tilt),
            acceleration=Window(times, acceleration),
            flags=np.array(flags, np.uint8),
            cell=self._polled(batch, "cell_voltage_v"),
            light=self._polled(batch, "light_v"),
            markers=tuple(self._tracker.on_batch(batch)),
        )
        if news.row_count:
            self._news.append(news)

    def write(self, recorder: Recorder) -> None:
        """What came since the last call, once its recording has begun."""
        opening = recorder.opening
        if opening is None or not self._news:
            return
        has_head = self._first_s is not None
        if self._first_s is None:
            self._first_s = min(news.first_s for news in self._news)
        for news in self._news:
            rows = csv_parts(news, wall_offset_s=opening.wall_offset_ns / 1e9, first_s=self._first_s)
            if has_head:
                next(rows)
            write_table(rows)
            has_head = True
        self._news = []

    def _polled(self, batch: Batch, key: str) -> Window:
        known = batch.conversation.values.get(key)
        if known is None or known.at <= self._polled_s[key]:
            return Window(np.empty(0), np.empty(0, np.float32))
        self._polled_s[key] = known.at
        return Window(np.array([known.at]), np.array([known.value], np.float32))


class RecordedSession:
    """A recorder from the first batch to `close`."""

    def __init__(self, recorder: Recorder, span: StreamSpan, table: LiveTable | None) -> None:
        self._recorder = recorder
        self._span = span
        self._table = table
        self._samples = 0
        self._marks: list[str] = []
        self.paths: list[Path] = []
        """More than one after a day."""

    def on_batch(self, batch: Batch) -> None:
        if not self.paths and not self._recorder.is_recording and self._recorder.trouble is None:
            self._recorder.begin(batch.connection.port, batch.connection.baud_rate)
        inside = tuple(sample for sample in batch.samples if self._span.holds(sample.at))
        unwanted = {sample.at for sample in batch.samples[len(inside) :]}
        events = tuple(event for event in batch.events if not (_is_report(event) and event.at in unwanted))
        wanted = batch._replace(samples=inside, events=events)
        if self._span.has_begun:
            self._marks += marks_in(batch)
        self._samples += len(inside)
        self._recorder.on_batch(wanted)
        if self._table is not None:
            self._table.on_batch(wanted)

    def on_turn(self, _opened: OpenPort) -> None:
        self._note_path()
        self._tell_marks()
        if self._recorder.trouble is not None:
            self._span.is_over = True  # nothing more is recorded: said now, not after the flight
        console.show_progress(labelled(tr("Reports"), f"{self._samples} (Ctrl-C)"))

    def close(self) -> None:
        """Wait until everything is on disk; print what is missing. Idempotent."""
        console.clear_progress()
        self._recorder.settle(SETTLE_LIMIT_S)
        try:
            self._note_path()
            self._tell_marks()
            if self._recorder.trouble is not None:
                console.notify(self._recorder.trouble.translated())
            if self._recorder.dropped:
                console.notify(tr("The disk was too slow. Not recorded: {count}.", count=self._recorder.dropped))
        finally:
            self._recorder.stop(SETTLE_LIMIT_S)

    @property
    def is_whole(self) -> bool:
        return not self._recorder.dropped and self._recorder.trouble is None

    def _tell_marks(self) -> None:
        marks, self._marks = self._marks, []
        for mark in marks:
            console.notify(mark)

    def _note_path(self) -> None:
        path = self._recorder.path
        if path is not None and path not in self.paths:
            self.paths.append(path)
        if self._table is not None:
            self._table.write(self._recorder)


def _is_report(event: Event) -> bool:
    return isinstance(event, Received) and isinstance(event.message, Status)


def write_files(session: RecordedSession, args: argparse.Namespace) -> bool:
    """Write the file, or one for each day; whether they are complete."""
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
