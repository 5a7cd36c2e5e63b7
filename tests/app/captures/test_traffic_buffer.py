"""The buffer of the line's traffic is bounded."""

from app.captures.traffic_buffer import MOST_ENTRIES, TrafficBuffer
from protocol.events import Received, Role
from protocol.frame import Direction, Frame
from protocol.messages import Status, decode

RAW = Status(7, 1.0, triggered=False, active=False).encode()


def test_old_entries_are_dropped_and_times_begin_at_zero() -> None:
    frame, status = Frame(Direction.MODULE_TO_HOST, RAW), decode(RAW)
    buffer = TrafficBuffer()
    buffer.feed(Received(frame, status, Role.STREAMED, float(at)) for at in range(MOST_ENTRIES))
    assert not buffer.has_dropped
    buffer.feed([Received(frame, status, Role.STREAMED, float(MOST_ENTRIES))])
    assert buffer.has_dropped
    assert len(buffer) == MOST_ENTRIES
    assert [entry.at_s for entry in buffer.entries(10)] == [float(at) for at in range(10)]
