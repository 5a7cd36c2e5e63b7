"""Bytes on the line as entries, and entries as text: the form in which a support bundle shows them."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from app.captures.entries import CaptureEntry, Way
from protocol.events import Event, Received, Rejected, Sent

MAGIC = "# DPS-S capture 1"
MAX_FILE_BYTES = 64 * 1024 * 1024
"""Limit of reading a file: 15 minutes of a full line, hours of a usual one."""
BYTES_A_LINE = 4096


@dataclass(frozen=True, slots=True, kw_only=True)
class Header:
    """Header of a capture; "" and None for missing fields."""

    program: str = ""
    port: str = ""
    baud_rate: int | None = None
    started: str = ""
    """ISO 8601, UTC."""

    def lines(self) -> Iterator[str]:
        yield MAGIC
        yield f"# program: {_one_line(self.program)}"
        yield f"# port: {_one_line(self.port)}"
        if self.baud_rate is not None:
            yield f"# baud_rate: {self.baud_rate}"
        if self.started:
            yield f"# started: {_one_line(self.started)}"
        if self.port.startswith("sim:"):
            yield "# simulated: yes"


def _one_line(text: str) -> str:
    return " ".join(text.split())


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
        if last is not None and is_more and len(last.raw) + len(entry.raw) <= BYTES_A_LINE:
            last = CaptureEntry(last.at_s, last.way, last.raw + entry.raw)
            continue
        if last is not None:
            yield last
        last = entry
    if last is not None:
        yield last


def lines_of(entry: CaptureEntry) -> Iterator[str]:
    """The line of an entry, or several for a long one."""
    for first in range(0, len(entry.raw), BYTES_A_LINE):
        raw = entry.raw[first : first + BYTES_A_LINE]
        yield f"{entry.at_s:.6f} {entry.way.value} {raw.hex(' ').upper()}"
