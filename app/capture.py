"""What went over the line, as a text file that another person's program can read; docs/capture.md describes it.

    # DPS-S capture 1
    # program: DPS-S Configurator 0.1.0
    # port: /dev/ttyUSB0
    # baud_rate: 115200
    # started: 2026-11-21T01:49:05Z
    0.000000 > 42 61 32 01 00 33
    0.002913 < 41 75 32 07 0A 00 01 44

Time in seconds since the header, direction (`>` host to module, `<` module to host), bytes. The reader takes plain hex
text too, without times and directions, and reports each line that it cannot read instead of giving up.
"""

import os
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from io import TextIOWrapper
from pathlib import Path
from typing import IO, BinaryIO

from app.capture_entries import Entries, Entry, Way
from app.hextext import HexText, NotHex
from app.pace import Pace
from protocol.catalogue import DEFAULT_BAUD_RATE
from protocol.events import Event, Received, Rejected, Sent
from protocol.frame import Direction, Frame
from protocol.stream import Piece, StreamParser
from protocol.text import marked

__all__ = [
    "Capture",
    "CaptureReader",
    "CaptureRefused",
    "CaptureWriter",
    "Entries",
    "Entry",
    "Header",
    "LineFault",
    "OpenCapture",
    "Way",
    "entries_of",
    "lines_of",
    "parse_capture",
    "read_capture",
]

MAGIC = "# DPS-S capture 1"
LONGEST_FILE_BYTES = 64 * 1024 * 1024
"""A file is not written beyond it (a quarter of an hour of a full line, hours of a usual one), nor read."""
LONGEST_LINE = 64 * 1024
BYTES_A_LINE = 4096
FAULTS_KEPT = 100
BITS_PER_BYTE = 10

_MAGIC = re.compile(r"#\s*DPS-S capture\s+(\d+)\s*")
_FIELD = re.compile(r"#\s*([a-z_]+)\s*:\s*(.*)")
_WAYS = {way.value: way for way in Way}
_ENTRY = re.compile(r"(\d{1,12}(?:\.\d{1,9})?)\s+([<>])\s*(.*)")


@dataclass(frozen=True, slots=True, kw_only=True)
class Header:
    """What a capture says about itself; "" and None where it does not."""

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


@dataclass(frozen=True, slots=True)
class LineFault:
    """A line that was left out. `line` counts from 1; `text` is English, translatable."""

    line: int
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Capture:
    """A capture as read. In plain hex text the times are those of bytes back to back, and `is_timed` is False."""

    header: Header = field(default_factory=Header)
    entries: Sequence[Entry] = ()
    faults: tuple[LineFault, ...] = ()
    is_timed: bool = True

    @property
    def duration_s(self) -> float:
        return self.entries[-1].at_s if self.entries else 0.0


class CaptureRefused(ValueError):
    """The file cannot be a capture: too long, or of a later version. The text is English, translatable."""


def _one_line(text: str) -> str:
    return " ".join(text.split())


# Writing


def entries_of(events: Iterable[Event], started_at: float) -> Iterator[Entry]:
    """What went over the wire in these events; what was read together becomes one entry, in its order.

    `started_at`: monotonic seconds that become time 0; earlier events count as 0.
    """
    last: Entry | None = None
    for event in events:
        match event:
            case Sent(raw=raw, at=at):
                entry = Entry(max(0.0, at - started_at), Way.OUT, raw)
            case Received(frame=frame, at=at):
                entry = Entry(max(0.0, at - started_at), Way.IN, frame.raw)
            case Rejected(noise=noise, at=at):
                entry = Entry(max(0.0, at - started_at), Way.IN, noise.raw)
            case _:
                continue
        is_more = last is not None and last.at_s == entry.at_s and last.way is entry.way is Way.IN
        if last is not None and is_more and len(last.raw) + len(entry.raw) <= BYTES_A_LINE:
            last = Entry(last.at_s, last.way, last.raw + entry.raw)
            continue
        if last is not None:
            yield last
        last = entry
    if last is not None:
        yield last


def lines_of(entry: Entry) -> Iterator[str]:
    """The line of an entry, or several where it is long."""
    for first in range(0, len(entry.raw), BYTES_A_LINE):
        raw = entry.raw[first : first + BYTES_A_LINE]
        yield f"{entry.at_s:.6f} {entry.way.value} {raw.hex(' ').upper()}"


class CaptureWriter:
    """Writes a capture line by line, and stops at its limit. Not safe to use from two threads.

    Raises OSError where the file cannot be written (read-only, full disk); what was written before stays readable.
    """

    def __init__(
        self, path: Path, header: Header, *, appends: bool = False, limit_bytes: int = LONGEST_FILE_BYTES
    ) -> None:
        """Makes the file anew, or with `appends` begins a new part at its end."""
        self.path = path
        self.is_full = False
        """The limit is reached: nothing more is written."""
        self.entries = 0
        self._limit_bytes = limit_bytes
        self._file: IO[str] | None = path.open("a" if appends else "w", encoding="utf-8", newline="\n")
        self._bytes = 0
        with self._closing_on_error() as file:
            self._bytes = file.tell()
            for line in header.lines():
                self._write(file, line)
            file.flush()

    def write(self, entries: Iterable[Entry]) -> None:
        """Append these entries and hand them to the system. After an error, and after `close`, it does nothing."""
        if self._file is None:
            return
        with self._closing_on_error() as file:
            for entry in entries:
                for line in lines_of(entry):
                    self._write(file, line)
                self.entries += not self.is_full
            file.flush()

    def close(self) -> None:
        """Idempotent. Raises OSError where the last lines could not be written."""
        file, self._file = self._file, None
        if file is not None:
            file.close()

    @contextmanager
    def _closing_on_error(self) -> Iterator[IO[str]]:
        file = self._file
        if file is None:
            raise ValueError("the capture is closed")
        try:
            yield file
        except OSError:
            with suppress(OSError):  # it tries once more to write what it could not
                self.close()
            raise

    def _write(self, file: IO[str], line: str) -> None:
        if self.is_full:
            return
        if self._bytes + len(line) + 1 > self._limit_bytes:
            self.is_full = True
            line = "# the file is full: what came afterwards is not in it"
        file.write(line + "\n")
        self._bytes += len(line) + 1


# Reading


class OpenCapture:
    """A capture file that is being read, entry by entry, by one thread."""

    def __init__(self, file: BinaryIO) -> None:
        """Raises OSError, or `CaptureRefused`."""
        self._file = file
        self._size = os.fstat(file.fileno()).st_size
        if self._size > LONGEST_FILE_BYTES + LONGEST_LINE:
            raise CaptureRefused(marked("the file is too long for a capture"))
        self._lines = TextIOWrapper(file, encoding="utf-8-sig", errors="replace")
        self.reader = CaptureReader(is_plain=_is_plain(self._lines))
        self._lines.seek(0)

    def entries(self) -> Iterator[Entry]:
        """All of them, once."""
        return self.reader.entries(self._lines)

    @property
    def share_read(self) -> float:
        """How much of the file has been read, 0 … 1."""
        return min(1.0, self._file.tell() / self._size) if self._size else 1.0


def read_capture(path: Path) -> Capture:
    """Raises OSError, or `CaptureRefused`."""
    with path.open("rb") as file:
        opened = OpenCapture(file)
        entries = Entries(opened.entries())
        return opened.reader.capture(entries)


def parse_capture(text: str) -> Capture:
    """Reads a capture, or hex text where no line looks like one. Raises `CaptureRefused` for a later version."""
    lines = text.removeprefix("\ufeff").splitlines()
    reader = CaptureReader(is_plain=_is_plain(lines))
    return reader.capture(Entries(reader.entries(lines)))


def _is_plain(lines: Iterable[str]) -> bool:
    pace = Pace()
    for line in lines:
        pace.keep()
        if _MAGIC.fullmatch(line.rstrip("\n")) or _ENTRY.fullmatch(line.strip()):
            return False
    return True


class CaptureReader:
    """One pass over the lines of a capture. Beside the main thread it rests now and then: see `Pace`."""

    def __init__(self, *, is_plain: bool = False) -> None:
        """`is_plain`: hex text, where no line looks like one of a capture."""
        self.is_plain = is_plain
        self.header = Header()
        self.faults: list[LineFault] = []
        self._last_s = 0.0
        self._has_entries = False
        self._part_begins_s = 0.0

    def capture(self, entries: Sequence[Entry]) -> Capture:
        """With the header and the faults of the lines that have been read."""
        return Capture(header=self.header, entries=entries, faults=tuple(self.faults), is_timed=not self.is_plain)

    def entries(self, lines: Iterable[str]) -> Iterator[Entry]:
        """One by one; header and faults are those of the lines that have been read."""
        pace = Pace()
        for entry in self._plain(lines) if self.is_plain else self._timed(lines):
            pace.keep()
            yield entry

    def _timed(self, lines: Iterable[str]) -> Iterator[Entry]:
        for number, line in enumerate(lines, start=1):
            entry = self._line(number, line.strip())
            if entry is not None:
                self._last_s, self._has_entries = entry.at_s, True
                yield entry

    def _line(self, number: int, line: str) -> Entry | None:
        if not line:
            return None
        if line.startswith("#"):
            self._comment(line)
            return None
        if len(line) > LONGEST_LINE:
            self._fault(number, marked("the line is too long"))
            return None
        found = _ENTRY.fullmatch(line)
        if found is None:
            self._fault(number, marked("no time, direction and bytes"))
            return None
        try:
            raw = _bytes_of(found[3])
        except NotHex:
            self._fault(number, marked("the bytes are no pairs of hex digits"))
            return None
        at_s = self._part_begins_s + float(found[1])
        if self._has_entries and at_s < self._last_s:
            self._fault(number, marked("the time runs backwards; the line before counts"))
            at_s = self._last_s
        return Entry(at_s, _WAYS[found[2]], raw) if raw else None

    def _comment(self, line: str) -> None:
        magic = _MAGIC.fullmatch(line)
        if magic is not None:
            if magic[1] != "1":
                raise CaptureRefused(marked("the capture is of a later version of the program"))
            # A part that was appended begins where the one before it ended.
            self._part_begins_s = self._last_s
            return
        named = _FIELD.fullmatch(line)
        if named is None or self._has_entries:
            return  # a remark; the header of the first part counts
        name, value = named[1], named[2].strip()
        if name == "baud_rate":
            if value.isascii() and value.isdigit() and len(value) < 9:
                self.header = replace(self.header, baud_rate=int(value))
        elif name in ("program", "port", "started"):
            self.header = replace(self.header, **{name: value})  # type: ignore[arg-type]

    def _plain(self, lines: Iterable[str]) -> Iterator[Entry]:
        """Hex text: whose bytes they are is told by the frames' headers; noise is the module's."""
        parser = StreamParser(follows_host=True)
        for number, line in enumerate(lines, start=1):
            try:
                raw = b"" if line.lstrip().startswith("#") else _bytes_of(line)
            except NotHex:
                self._fault(number, marked("no pairs of hex digits"))
                continue
            for first in range(0, len(raw), BYTES_A_LINE):
                yield from map(_plain_entry, parser.feed(raw[first : first + BYTES_A_LINE]))
        yield from map(_plain_entry, parser.flush())

    def _fault(self, number: int, text: str) -> None:
        if len(self.faults) < FAULTS_KEPT:
            self.faults.append(LineFault(number, text))


def _bytes_of(text: str) -> bytes:
    try:
        return bytes.fromhex(text)  # nearly always
    except ValueError:
        reader = HexText()
        raw = reader.feed(text)
        reader.finish()
        return raw


def _plain_entry(piece: Piece) -> Entry:
    is_ours = isinstance(piece, Frame) and piece.direction is Direction.HOST_TO_MODULE
    return Entry(piece.offset * BITS_PER_BYTE / DEFAULT_BAUD_RATE, Way.OUT if is_ours else Way.IN, piece.raw)
