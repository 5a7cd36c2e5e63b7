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
    together, at_s, way = bytearray(), 0.0, Way.OUT
    for event in events:
        if isinstance(event, Received):
            raw = event.frame.raw
        elif isinstance(event, Rejected):
            raw = event.noise.raw
        elif isinstance(event, Sent):
            raw = event.raw
        else:
            continue
        is_more = way is Way.IN and not isinstance(event, Sent) and event.at == at_s
        if together and not (is_more and len(together) + len(raw) <= MAX_ENTRY_BYTES):
            yield CaptureEntry(max(0.0, at_s - started_at), way, bytes(together))
            together = bytearray()
        together += raw
        at_s, way = event.at, Way.OUT if isinstance(event, Sent) else Way.IN
    if together:
        yield CaptureEntry(max(0.0, at_s - started_at), way, bytes(together))


def line_of(entry: CaptureEntry) -> str:
    """As `app.captures.text` reads it."""
    return f"{entry.at_s:.6f} {entry.way.value} {entry.raw.hex(' ').upper()}"
