"""The latest bytes of the line, in bounded memory, ready to be saved as a session."""

from collections import deque
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from itertools import chain, islice

from app.captures.entries import CaptureEntry, entries_of
from app.captures.line import LineBytes
from app.system.wall_clock import WallClock
from protocol.events import Event

MAX_ENTRIES = 100_000
"""Half an hour of a usual stream, ten minutes of a full line. Older entries are in the session's recording."""
MAX_BYTES = 8_000_000
PART_ENTRIES = 1000
_PART_BYTES = 64 * 1024


class TrafficBuffer:
    """Bytes that were sent and received, oldest first. Not thread-safe.

    Kept in parts: many small objects that come and go fragment the memory, and the garbage collector visits each.
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        self._parts: deque[LineBytes] = deque()
        self._newest: list[CaptureEntry] = []
        """Not yet in a part."""
        self._count = self._bytes = self._newest_bytes = 0
        self._doubted_at: list[float] = []
        self.wall = WallClock()
        self.has_dropped = False

    def __len__(self) -> int:
        return self._count

    def feed(self, events: Iterable[Event], doubted_at: Iterable[float] = ()) -> None:
        """`doubted_at`: from when on they may be of another module."""
        self.wall.poll()
        self._doubted_at += doubted_at
        for entry in entries_of(events, 0.0):
            self._newest.append(entry)
            self._count += 1
            self._bytes += len(entry.raw)
            self._newest_bytes += len(entry.raw)
            if len(self._newest) >= PART_ENTRIES or self._newest_bytes >= _PART_BYTES:
                self._parts.append(LineBytes.of(self._newest))
                self._newest, self._newest_bytes = [], 0
        while self._parts and (self._count > MAX_ENTRIES or self._bytes > MAX_BYTES):
            oldest = self._parts.popleft()
            self._count -= len(oldest)
            self._bytes -= len(oldest.received.raw) + len(oldest.sent.raw)
            self.has_dropped = True

    def entries(self, most: int | None = None) -> tuple[CaptureEntry, ...]:
        """The last `most`, or all, with times that begin at 0."""
        last = self._last(most)
        first = next(last, None)
        if first is None:
            return ()
        return tuple(CaptureEntry(at_s - first.at_s, way, raw) for at_s, way, raw in chain((first,), last))

    def doubted_at(self) -> tuple[float, ...]:
        """In the time of all `entries`."""
        first = next(self._last(None), None)
        return () if first is None else tuple(max(0.0, at_s - first.at_s) for at_s in self._doubted_at)

    def started_at(self, most: int | None = None) -> datetime:
        """When the first of `entries(most)` was on the line, UTC."""
        first = next(self._last(most), None)
        return datetime.fromtimestamp(0.0 if first is None else self.wall.at(first.at_s), UTC)

    def _last(self, most: int | None) -> Iterator[CaptureEntry]:
        skipped = 0 if most is None else max(0, self._count - most)
        for part in (*self._parts, LineBytes.of(self._newest)):
            if skipped < len(part):
                yield from islice(part.entries(), skipped, None)
            skipped = max(0, skipped - len(part))
