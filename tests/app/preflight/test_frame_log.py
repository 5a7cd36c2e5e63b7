"""The raw frames of a check: all of them, but of a stream the first ones, within a bound."""

import pytest

from app.preflight import evidence
from app.preflight.evidence import FrameLog
from protocol.catalogue import HEARTBEAT, HEARTBEAT_REPLY
from protocol.events import Received, Rejected, Role, Sent
from protocol.frame import Direction, Fault, Frame, Noise, Reason

FRAME = Frame(Direction.MODULE_TO_HOST, HEARTBEAT_REPLY)


def received(role: Role, count: int) -> list[Received]:
    return [Received(FRAME, None, role, float(number)) for number in range(count)]


def test_of_a_stream_only_the_first_reports_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evidence, "MAX_STREAMED", 3)
    log = FrameLog()
    sent = Sent(HEARTBEAT.query().encode(), HEARTBEAT.query(), 1, 0.0)
    noise = Rejected(Noise(b"x", Fault(Reason.NO_HEADER, "noise"), 0), 0.0)
    log.feed([sent, *received(Role.ANSWER, 2), *received(Role.STREAMED, 7), *received(Role.ANSWER, 2), noise])
    assert (len(log.frames), log.left_out) == (9, 4)
    assert (log.frames[0].way, log.frames[1].way, log.frames[-1].way) == ("out", "in", "noise")


def test_no_more_frames_are_kept_than_the_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evidence, "MAX_FRAMES", 5)
    log = FrameLog()
    log.feed(received(Role.ANSWER, 7))
    assert (len(log.frames), log.left_out) == (5, 2)
