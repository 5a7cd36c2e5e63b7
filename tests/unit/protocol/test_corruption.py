"""One-bit and two-bit errors of every frame: what is noticed, and what no host can notice.

An eight-bit sum misses a two-bit error that takes from one byte what it gives to the sum.
"""

from collections.abc import Iterator
from itertools import combinations

import pytest

from protocol.catalogue import BY_NAME, Request
from protocol.messages import Acknowledgement, Direction, Frame, Reading, answers, decode
from protocol.stream import StreamParser
from tests.vendor.frames import FROM_MODULE, VALID, Vector


def corruptions(raw: bytes, bits: int) -> Iterator[bytes]:
    """`raw` with every choice of `bits` different bits flipped."""
    number = int.from_bytes(raw)
    for positions in combinations(range(8 * len(raw)), bits):
        yield (number ^ sum(1 << position for position in positions)).to_bytes(len(raw))


def frames_in(raw: bytes, asked: Request | None) -> list[Frame]:
    parser = StreamParser(asked=asked)
    return [piece for piece in parser.feed(raw) + parser.flush() if isinstance(piece, Frame)]


def request_for(name: str, raw: bytes) -> Request:
    """What the host sent to get this reply."""
    command = BY_NAME[name]
    if command.query_data is not None:
        return command.query()
    assert command.write is not None
    return command.set(command.write.decode(raw[4]))


@pytest.mark.parametrize("vector", VALID, ids=lambda vector: vector.id)
@pytest.mark.promise("g")
def test_e13_no_one_bit_error_goes_unnoticed(vector: Vector) -> None:
    asked = BY_NAME[vector.while_asked].query() if vector.while_asked == "cell_voltage" else None
    assert all(not frames_in(corrupted, asked) for corrupted in corruptions(vector.raw, 1))


@pytest.mark.parametrize("vector", FROM_MODULE, ids=lambda vector: vector.id)
@pytest.mark.promise("g")
def test_a_corrupted_reply_never_answers_for_another_command(vector: Vector) -> None:
    assert vector.means is not None
    asked = request_for(str(vector.means["command"]), vector.raw)
    for corrupted in corruptions(vector.raw, 2):
        for frame in frames_in(corrupted, asked):
            if frame.direction is Direction.MODULE_TO_HOST and answers(frame.raw, asked):
                message = decode(frame.raw, asked)
                if isinstance(message, Reading | Acknowledgement):
                    told = message.command if isinstance(message, Reading) else message.request.command
                    assert told is asked.command
