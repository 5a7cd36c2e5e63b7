"""The latest bytes of the line, in bounded memory, for a support bundle."""

from collections import deque
from collections.abc import Iterable
from datetime import UTC, datetime

from app.captures.entries import CaptureEntry, entries_of
from app.system.wall_clock import wall_offset_s
from protocol.events import Event

MAX_ENTRIES = 20_000
"""Minutes of a usual stream. All of it is in the session's recording."""
MAX_BYTES = 8_000_000


class TrafficBuffer:
    """Bytes that were sent and received, oldest first. Not thread-safe."""

    def __init__(self) -> None:
        self._entries: deque[CaptureEntry] = deque()
        self._bytes = 0

    def clear(self) -> None:
        self._entries.clear()
        self._bytes = 0

    def feed(self, events: Iterable[Event]) -> None:
        for entry in entries_of(events, 0.0):
            self._entries.append(entry)
            self._bytes += len(entry.raw)
        while len(self._entries) > MAX_ENTRIES or self._bytes > MAX_BYTES:
            self._bytes -= len(self._entries.popleft().raw)

    def entries(self) -> tuple[CaptureEntry, ...]:
        """All that are kept, with times that begin at 0."""
        if not self._entries:
            return ()
        first_s = self._entries[0].at_s
        return tuple(entry._replace(at_s=entry.at_s - first_s) for entry in self._entries)

    def started_at(self) -> datetime | None:
        """When the first of `entries` was on the line, UTC."""
        return datetime.fromtimestamp(self._entries[0].at_s + wall_offset_s(), UTC) if self._entries else None
