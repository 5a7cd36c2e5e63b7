"""The latest bytes of the line, in bounded memory, ready to be saved as a capture."""

from collections import deque
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from itertools import islice

from app import version
from app.captures.entries import CaptureEntry
from app.captures.writer import Header, entries_of
from app.system.wall_clock import WallClock
from protocol.events import Event

MAX_BYTES = 16_000_000
"""Limit of memory: half an hour of a usual stream, ten minutes of a full line. Older entries are in the session's
recording. As text it is smaller than `MAX_FILE_BYTES`, so that it can be opened again."""
ENTRY_BYTES = 150
"""Memory of an entry besides its bytes."""


class TrafficBuffer:
    """Bytes that were sent and received, oldest first. Not thread-safe."""

    def __init__(self) -> None:
        self._entries: deque[CaptureEntry] = deque()
        self._bytes = 0
        self.wall = WallClock()
        self.has_dropped = False
        """Older entries were dropped."""

    def __len__(self) -> int:
        return len(self._entries)

    def feed(self, events: Iterable[Event]) -> None:
        self.wall.poll()
        for entry in entries_of(events, 0.0):
            self._entries.append(entry)
            self._bytes += ENTRY_BYTES + len(entry.raw)
        while self._bytes > MAX_BYTES:
            self._bytes -= ENTRY_BYTES + len(self._entries.popleft().raw)
            self.has_dropped = True

    def entries(self, most: int | None = None) -> tuple[CaptureEntry, ...]:
        """The last `most`, or all, with times that begin at 0."""
        last = tuple(self._last(most))
        began_s = last[0].at_s if last else 0.0
        return tuple(entry._replace(at_s=entry.at_s - began_s) for entry in last)

    def header(self, port: str, baud_rate: int, most: int | None = None) -> Header:
        """The header of a file with `entries(most)`."""
        first = next(self._last(most), None)
        started = "" if first is None else _iso(self.wall.at(first.at_s))
        return Header(
            program=f"DPS-S Configurator {version()}", port=port, baud_rate=baud_rate or None, started=started
        )

    def _last(self, most: int | None) -> Iterator[CaptureEntry]:
        first = 0 if most is None else max(0, len(self._entries) - most)
        return islice(self._entries, first, None)


def _iso(wall_s: float) -> str:
    return datetime.fromtimestamp(wall_s, UTC).isoformat(timespec="seconds").replace("+00:00", "Z")
