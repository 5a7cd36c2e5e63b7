"""Writes session files from bytes of the module and events, without recording them."""

from collections.abc import Iterable
from heapq import merge
from operator import itemgetter
from pathlib import Path

import msgspec

from app.captures.traffic import CaptureEntry
from app.recordings.recorder import FLUSH_EVERY_S
from app.recordings.session_file import RX, STATUS, Opening, RecordedReport, SessionWriter
from protocol.frame import Frame
from protocol.messages import Status, decode
from protocol.stream import StreamParser

Note = tuple[float, dict[str, object]]


def write_session(path: Path, opening: Opening, entries: Iterable[CaptureEntry], notes: Iterable[Note] = ()) -> None:
    """Write a session that was closed properly; entries and notes are both in order of time (monotonic)."""
    path.unlink(missing_ok=True)
    writer, parser = SessionWriter(path, opening), StreamParser()
    flush_s = opening.start_s + FLUSH_EVERY_S
    streams: tuple[Iterable[CaptureEntry | Note], ...] = notes, entries
    for recorded in merge(*streams, key=itemgetter(0)):
        if recorded[0] > flush_s:
            writer.flush(opening.start_s)
            flush_s = recorded[0] + FLUSH_EVERY_S
        if isinstance(recorded, CaptureEntry):
            _write(writer, recorded, parser)
        else:
            writer.note(recorded[0], **recorded[1])  # type: ignore[arg-type]
    writer.flush(opening.start_s, is_last=True)
    writer.close()


def _write(writer: SessionWriter, entry: CaptureEntry, parser: StreamParser) -> None:
    """The bytes, and the reports in them."""
    at_ns = writer.wall_ns(entry.at_s)
    writer.add(RX, at_ns, entry.raw)
    for piece in parser.feed(entry.raw):
        message = decode(piece.raw) if isinstance(piece, Frame) else None
        if isinstance(message, Status):
            values = message.tilt_deg, message.acceleration_g, message.triggered, message.active
            writer.add(STATUS, at_ns, msgspec.json.encode(RecordedReport(*values)))
            writer.advance(reports=writer.state.reports + 1)
