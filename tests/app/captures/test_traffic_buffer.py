"""The buffer of the line's traffic is bounded."""

import sys

from app.captures.entries import MAX_ENTRY_BYTES, CaptureEntry, Way
from app.captures.traffic_buffer import MAX_BYTES, MAX_ENTRIES, PART_ENTRIES, TrafficBuffer
from protocol.catalogue import STATUS
from protocol.events import Event, Received, Rejected, Role, Sent
from protocol.frame import Direction, Fault, Frame, Noise, Reason
from protocol.messages import Status, decode

RAW = Status(7, 1.0, triggered=False, active=False).encode()
FRAME = Frame(Direction.MODULE_TO_HOST, RAW)
STATUS_READ = decode(RAW)


def status(at: int) -> Event:
    return Received(FRAME, STATUS_READ, Role.STREAMED, float(at))


def asked(at: int) -> Event:
    return Sent(STATUS.query().encode(), STATUS.query(), 1, float(at))


def noise(at: int) -> Event:
    return Rejected(Noise(bytes(MAX_ENTRY_BYTES), Fault(Reason.NO_HEADER, ""), 0), float(at))


def test_old_entries_are_dropped_and_times_begin_at_zero() -> None:
    buffer = TrafficBuffer()
    buffer.feed(status(at) for at in range(MAX_ENTRIES))
    assert not buffer.has_dropped
    assert len(buffer) == MAX_ENTRIES
    buffer.feed([status(MAX_ENTRIES)])
    assert buffer.has_dropped
    assert MAX_ENTRIES - PART_ENTRIES <= len(buffer) <= MAX_ENTRIES
    assert [entry.at_s for entry in buffer.entries(10)] == [float(at) for at in range(10)]
    everything = buffer.entries()
    assert len(everything) == len(buffer)
    assert [entry.at_s for entry in everything] == [float(at) for at in range(len(buffer))]


def test_every_entry_is_kept_as_it_was() -> None:
    buffer, wanted = TrafficBuffer(), list[CaptureEntry]()
    for at in range(3 * PART_ENTRIES + 7):
        buffer.feed([asked(at), status(at), status(at)] if at % 3 else [status(at)])
        wanted += [CaptureEntry(float(at), Way.OUT, STATUS.query().encode())] if at % 3 else []
        wanted.append(CaptureEntry(float(at), Way.IN, RAW * 2 if at % 3 else RAW))
    assert buffer.entries() == tuple(wanted)
    assert [entry.raw for entry in buffer.entries(5000)] == [entry.raw for entry in wanted[-5000:]]
    assert [entry.raw for entry in buffer.entries(3)] == [entry.raw for entry in wanted[-3:]]


def test_with_the_longest_entries_its_memory_is_bounded() -> None:
    buffer = TrafficBuffer()
    buffer.feed(noise(at) for at in range(2 * MAX_BYTES // MAX_ENTRY_BYTES))
    assert buffer.has_dropped
    entries = buffer.entries()
    assert MAX_BYTES / 2 <= sum(len(entry.raw) for entry in entries) <= MAX_BYTES


def test_a_full_buffer_is_a_few_large_objects() -> None:
    buffer = TrafficBuffer()
    before = sys.getallocatedblocks()
    buffer.feed(status(at) for at in range(MAX_ENTRIES))
    assert sys.getallocatedblocks() - before < MAX_ENTRIES / 10
