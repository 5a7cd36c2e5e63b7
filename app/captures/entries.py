"""Entries of a capture: bytes on the line, with their time and direction."""

from collections.abc import Iterable, Iterator
from enum import Enum
from typing import Final, NamedTuple

from protocol.events import Event, Received, Rejected, Sent

MAX_ENTRY_BYTES: Final = 4096


class Way(Enum):
    """Direction of bytes on the line. The value is the character in text."""

    OUT = ">"
    IN = "<"


class CaptureEntry(NamedTuple):
    """Bytes that were sent or received together. `at_s`: seconds since the capture began."""

    at_s: float
    way: Way
    raw: bytes


def entries_of(events: Iterable[Event], started_at: float) -> Iterator[CaptureEntry]:
    """The bytes of these events; bytes that were received together become one entry.

    `started_at`: monotonic time that becomes 0, also for earlier events.
    """
    last: CaptureEntry | None = None
    for event in events:
        match event:
            case Sent(raw=raw, at=at):
                entry = CaptureEntry(max(0.0, at - started_at), Way.OUT, raw)
            case Received(frame=frame, at=at):
                entry = CaptureEntry(max(0.0, at - started_at), Way.IN, frame.raw)
            case Rejected(noise=noise, at=at):
                entry = CaptureEntry(max(0.0, at - started_at), Way.IN, noise.raw)
            case _:
                continue
        is_more = last is not None and last.at_s == entry.at_s and last.way is entry.way is Way.IN
        if last is not None and is_more and len(last.raw) + len(entry.raw) <= MAX_ENTRY_BYTES:
            last = CaptureEntry(last.at_s, last.way, last.raw + entry.raw)
            continue
        if last is not None:
            yield last
        last = entry
    if last is not None:
        yield last


def line_of(entry: CaptureEntry) -> str:
    """As `app.captures.text` reads it."""
    return f"{entry.at_s:.6f} {entry.way.value} {entry.raw.hex(' ').upper()}"
