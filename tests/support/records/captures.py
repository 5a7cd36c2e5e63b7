"""A short capture for tests, and functions to write and read it."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

from app.captures.entries import CaptureEntry, Way
from app.captures.explained import Explained, Explainer
from app.captures.reader import CaptureReader, LineFault, read_text
from app.captures.writer import Header, lines_of
from app.recordings.library import entry_of
from app.recordings.recording import traffic_of
from protocol.catalogue import STATUS
from protocol.messages import Status

EMPTY_SLOT = bytes.fromhex("41 75 35 01 00 00 00 00 00 00 00 00 00 00 00 36")
STATUS_FRAME = Status(7, 1.0, triggered=False, active=True).encode()
HEADER = Header(program="DPS-S 1.2", port="/dev/ttyUSB0", baud_rate=115200, started="2026-11-21T01:49:05Z")
ENTRIES = (
    CaptureEntry(0.0, Way.OUT, STATUS.query().encode()),
    CaptureEntry(0.002913, Way.IN, STATUS_FRAME),
    CaptureEntry(0.5, Way.IN, b"\x00\xff" + STATUS_FRAME[:3]),
    CaptureEntry(3600.25, Way.IN, STATUS_FRAME[3:]),
)


@dataclass(frozen=True)
class Capture:
    """A capture that was read whole."""

    header: Header = field(default_factory=Header)
    entries: Sequence[CaptureEntry] = ()
    faults: Sequence[LineFault] = ()
    is_plain: bool = False

    @property
    def duration_s(self) -> float:
        return self.entries[-1].at_s if self.entries else 0.0


def read_capture(path: Path) -> Capture:
    """Raises OSError, or `CaptureRefused`."""
    reader = CaptureReader()
    with path.open("rb") as file:
        entries = tuple(entry for some in read_text(file, reader) for entry in some)
    return Capture(reader.header, entries, tuple(reader.faults), reader.is_plain)


def read_session(path: Path) -> Sequence[CaptureEntry]:
    """What went over the line in a session."""
    return tuple(traffic_of(entry_of(path)))


def parse_capture(text: str) -> Capture:
    """The same for a text."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "capture")
        path.write_bytes(text.encode("utf-8", "replace"))
        return read_capture(path)


def explained(entries: Iterable[CaptureEntry]) -> Iterator[Explained]:
    explainer = Explainer()
    for entry in entries:
        yield from explainer.feed(entry)
    yield from explainer.end()


def written(path: Path, entries: Sequence[CaptureEntry] = ENTRIES, header: Header = HEADER) -> None:
    lines = (line for entry in entries for line in lines_of(entry))
    path.write_text("".join(f"{line}\n" for line in (*header.lines(), *lines)), "utf-8", newline="\n")
