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

MOST_ENTRIES = 60_000
"""Half an hour of a usual stream, 40 s of a full line; some 10 MB. What is older is in the session's recording."""


class TrafficBuffer:
    """What went over the line, oldest first. Belongs to one thread."""

    def __init__(self) -> None:
        self._entries: deque[CaptureEntry] = deque(maxlen=MOST_ENTRIES)
        self.wall = WallClock()
        self.has_dropped = False
        """Older entries were dropped."""

    def __len__(self) -> int:
        return len(self._entries)

    def feed(self, events: Iterable[Event]) -> None:
        self.wall.poll()
        new = list(entries_of(events, 0.0))
        self.has_dropped |= len(self._entries) + len(new) > MOST_ENTRIES
        self._entries.extend(new)

    def entries(self, most: int = MOST_ENTRIES) -> tuple[CaptureEntry, ...]:
        """The last `most`, with times that begin at 0."""
        last = tuple(self._last(most))
        began_s = last[0].at_s if last else 0.0
        return tuple(entry._replace(at_s=entry.at_s - began_s) for entry in last)

    def header(self, port: str, baud_rate: int, most: int = MOST_ENTRIES) -> Header:
        """The header of a file with `entries(most)`."""
        first = next(self._last(most), None)
        started = "" if first is None else _iso(self.wall.at(first.at_s))
        return Header(
            program=f"DPS-S Configurator {version()}", port=port, baud_rate=baud_rate or None, started=started
        )

    def _last(self, most: int) -> Iterator[CaptureEntry]:
        return islice(self._entries, max(0, len(self._entries) - most), None)


def _iso(wall_s: float) -> str:
    return datetime.fromtimestamp(wall_s, UTC).isoformat(timespec="seconds").replace("+00:00", "Z")
