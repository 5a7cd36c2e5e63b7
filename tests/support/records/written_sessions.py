"""Writes session files from bytes on the line and events, without recording them."""

from collections.abc import Iterable
from heapq import merge
from operator import itemgetter
from pathlib import Path

from app.captures.entries import CaptureEntry
from app.recordings.recorder import FLUSH_EVERY_S
from app.recordings.session_format import Opening
from app.recordings.writer import SessionWriter

Note = tuple[float, dict[str, object]]


def write_session(path: Path, opening: Opening, entries: Iterable[CaptureEntry], notes: Iterable[Note] = ()) -> None:
    """Write a session that was closed properly; entries and notes are both in order of time (monotonic)."""
    path.unlink(missing_ok=True)
    writer = SessionWriter(path, opening)
    flush_s = opening.start_s + FLUSH_EVERY_S
    streams: tuple[Iterable[CaptureEntry | Note], ...] = notes, entries
    for recorded in merge(*streams, key=itemgetter(0)):
        if recorded[0] > flush_s:
            writer.flush(writer.state.end_s)
            flush_s = recorded[0] + FLUSH_EVERY_S
        if isinstance(recorded, CaptureEntry):
            writer._entries.append(recorded)
        else:
            writer._notes.append(recorded)
    writer.flush(writer.state.end_s)
    writer.flush(writer.state.end_s, is_last=True)
    writer.close()
