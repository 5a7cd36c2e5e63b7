"""The buffer of the line's traffic is bounded."""

from app.captures.traffic_buffer import ENTRY_BYTES, MAX_BYTES, TrafficBuffer
from app.captures.writer import BYTES_A_LINE, MAX_FILE_BYTES, capture_parts
from protocol.events import Event, Received, Rejected, Role
from protocol.frame import Direction, Fault, Frame, Noise, Reason
from protocol.messages import Status, decode

RAW = Status(7, 1.0, triggered=False, active=False).encode()
FRAME = Frame(Direction.MODULE_TO_HOST, RAW)
STATUS = decode(RAW)


def status(at: int) -> Event:
    return Received(FRAME, STATUS, Role.STREAMED, float(at))


def noise(at: int) -> Event:
    return Rejected(Noise(bytes(BYTES_A_LINE), Fault(Reason.NO_HEADER, ""), 0), float(at))


def test_old_entries_are_dropped_and_times_begin_at_zero() -> None:
    most = MAX_BYTES // (ENTRY_BYTES + len(FRAME.raw))
    buffer = TrafficBuffer()
    buffer.feed(status(at) for at in range(most))
    assert not buffer.has_dropped
    buffer.feed([status(most)])
    assert buffer.has_dropped
    assert len(buffer) == most
    assert [entry.at_s for entry in buffer.entries(10)] == [float(at) for at in range(10)]
    assert buffer.entries()[0].at_s == 0.0


def test_with_the_longest_entries_its_memory_is_bounded_and_its_capture_can_be_opened() -> None:
    buffer = TrafficBuffer()
    buffer.feed(noise(at) for at in range(MAX_BYTES // BYTES_A_LINE))
    assert buffer.has_dropped
    entries = buffer.entries()
    assert sum(len(entry.raw) for entry in entries) <= MAX_BYTES
    assert sum(map(len, capture_parts(entries, buffer.header("/dev/ttyUSB0", 115200)))) <= MAX_FILE_BYTES
