"""Writes session files from bytes on the line and events, without recording them."""

from collections.abc import Iterable
from heapq import merge
from operator import itemgetter
from pathlib import Path

from app.captures.traffic import CaptureEntry, Way
from app.engine.conversation import ConversationView, StatusSample
from app.engine.worker import Batch, Connection
from app.recordings.recorder import FLUSH_EVERY_S
from app.recordings.session_file import Opening
from app.recordings.writer import SessionWriter
from protocol.events import Event, Received, Rejected, Role
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
            writer.put(_received(recorded, parser), ())
        else:
            writer.note(recorded[0], **recorded[1])  # type: ignore[arg-type]
    writer.flush(opening.start_s)
    writer.flush(opening.start_s, is_last=True)
    writer.close()


def _received(entry: CaptureEntry, parser: StreamParser) -> Batch:
    """What the link makes of bytes of the module."""
    assert entry.way is Way.IN
    events, samples = list[Event](), list[StatusSample]()
    for piece in parser.feed(entry.raw):
        if not isinstance(piece, Frame):
            events.append(Rejected(piece, entry.at_s))
            continue
        message = decode(piece.raw)
        events.append(Received(piece, message, Role.STREAMED, entry.at_s))
        if isinstance(message, Status):
            samples.append(
                StatusSample(entry.at_s, message.tilt_deg, message.acceleration_g, message.triggered, message.active)
            )
    return Batch(entry.at_s, Connection(), ConversationView(), None, tuple(samples), tuple(events))
