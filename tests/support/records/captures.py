"""A short capture for tests, and functions to write and read it."""

from collections.abc import Sequence
from itertools import islice
from pathlib import Path

from app.captures.entries import CaptureEntry, Way
from app.captures.reader import Capture
from app.captures.script import Script
from app.captures.writer import CaptureWriter, Header
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


def written(path: Path, entries: Sequence[CaptureEntry] = ENTRIES, header: Header = HEADER) -> None:
    writer = CaptureWriter(path, header)
    writer.write(entries)
    writer.close()


def script_of(capture: Capture) -> Script:
    """Return the script of a capture, read to its end."""
    entries = iter(capture.entries)
    script = Script(iter(lambda: tuple(islice(entries, 100)), ()), lambda: capture.duration_s)
    while not script.is_read:
        script.read_on()
    return script
