"""The raw frames of a check: all of them, but of a stream the first ones, within a bound."""

from app.preflight.evidence import FrameLog
from protocol.catalogue import HEARTBEAT, HEARTBEAT_REPLY
from protocol.events import Received, Rejected, Role, Sent
from protocol.frame import Direction, Fault, Frame, Noise, Reason

FRAME = Frame(Direction.MODULE_TO_HOST, HEARTBEAT_REPLY)


def received(role: Role, count: int) -> list[Received]:
    return [Received(FRAME, None, role, float(number)) for number in range(count)]


def test_of_a_stream_only_the_first_reports_are_kept() -> None:
    log = FrameLog()
    sent = Sent(HEARTBEAT.query().encode(), HEARTBEAT.query(), 1, 0.0)
    noise = Rejected(Noise(b"x", Fault(Reason.NO_HEADER, "noise"), 0), 0.0)
    log.feed([sent, *received(Role.ANSWER, 2), *received(Role.STREAMED, 204), *received(Role.ANSWER, 2), noise])
    assert (len(log.frames), log.left_out) == (206, 4)
    assert (log.frames[0].way, log.frames[1].way, log.frames[-1].way) == ("out", "in", "noise")


def test_no_more_frames_are_kept_than_the_bound() -> None:
    log = FrameLog()
    log.feed(received(Role.ANSWER, 1502))
    assert (len(log.frames), log.left_out) == (1500, 2)
