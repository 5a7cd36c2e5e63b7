"""All one-bit and two-bit errors of every frame: what is noticed, and what cannot be.

An eight-bit sum misses a two-bit error that takes from one byte what it gives to the sum. The figures below are exact:
a change of the codec that lets more through, or notices more, changes them.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from itertools import combinations

import pytest

from app.captures.explain import meaning, sentence
from protocol.catalogue import BY_NAME, COMMANDS, Hazard, Request
from protocol.frame import Direction, Frame, decode_request
from protocol.messages import Acknowledgement, Reading, answers, decode
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


def catalogue_requests() -> tuple[Request, ...]:
    """Every query, every act, and sets of every flag and of the smallest, the delivered and the largest value."""
    requests = [command.query() for command in COMMANDS if command.query_data is not None]
    for command in COMMANDS:
        if command.write is not None:
            allowed = sorted(command.write.allowed)
            chosen = {allowed[0], allowed[-1]} | ({command.default} if command.default is not None else set())
            requests += [command.set(command.write.decode(raw)) for raw in sorted(chosen)]
    return tuple(requests)


def request_for(name: str, raw: bytes) -> Request:
    """What the host sent to get this reply."""
    command = BY_NAME[name]
    if command.query_data is not None:
        return command.query()
    assert command.write is not None
    return command.set(command.write.decode(raw[4]))


def exchanges() -> Iterator[tuple[Request, bytes]]:
    """Every reply of the table with the request that it answers."""
    for vector in FROM_MODULE:
        assert vector.means is not None
        yield request_for(str(vector.means["command"]), vector.raw), vector.raw


@dataclass(slots=True)
class Figures:
    """How many corrupted frames there were, and what became of them."""

    tried: int = 0
    same_length: int = 0
    """A valid frame of the same length: undetected by sum, code, control byte and value."""
    answering: Counter[str] = field(default_factory=Counter)
    """Undetected and taken as the answer to what was asked, by its command."""


@cache
def figures_of_replies(bits: int) -> Figures:
    figures = Figures()
    for asked, raw in exchanges():
        for corrupted in corruptions(raw, bits):
            figures.tried += 1
            for frame in frames_in(corrupted, asked):
                figures.same_length += len(frame.raw) == len(raw)
                message = decode(frame.raw, asked)
                meaning(frame, asked)
                sentence(frame, asked)
                if frame.direction is Direction.MODULE_TO_HOST and answers(frame.raw, asked):
                    match message:
                        case Reading(command=command) | Acknowledgement(request=Request(command=command)):
                            figures.answering[f"{asked.command.name} by {command.name}"] += 1
                        case _:
                            figures.answering[f"{asked.command.name} by {type(message).__name__}"] += 1
    return figures


@cache
def changed_requests(bits: int) -> tuple[int, tuple[tuple[Request, Request], ...]]:
    """Corrupted host frames tried, and those that are a valid request again: what was sent, what arrives."""
    tried = 0
    changed = []
    for request in catalogue_requests():
        for corrupted in corruptions(request.encode(), bits):
            tried += 1
            for frame in frames_in(corrupted, None):
                assert frame.direction is Direction.HOST_TO_MODULE
                changed.append((request, decode_request(frame.raw)))
    return tried, tuple(changed)


@pytest.mark.parametrize("vector", VALID, ids=lambda vector: vector.id)
@pytest.mark.promise("g")
def test_e13_no_one_bit_error_goes_unnoticed(vector: Vector) -> None:
    asked = BY_NAME[vector.while_asked].query() if vector.while_asked == "cell_voltage" else None
    assert all(not frames_in(corrupted, asked) for corrupted in corruptions(vector.raw, 1))


@pytest.mark.promise("g")
def test_a_corrupted_reply_never_answers_for_another_command() -> None:
    answering = figures_of_replies(2).answering
    assert answering == {
        "trigger_records by TriggerRecord": 395,
        "cell_voltage by cell_voltage": 28,
        "status by Status": 17,
        "triggered by triggered": 10,
        "active by active": 9,
        "freefall_acceleration by freefall_acceleration": 6,
        "freefall_trigger by freefall_trigger": 6,
        "attitude_threshold by attitude_threshold": 5,
        "light_threshold by light_threshold": 4,
        "freefall_time by freefall_time": 4,
        "deploy by deploy": 2,
        "serial_output by serial_output": 2,
        "charging by charging": 2,
        "baud_rate by baud_rate": 1,
    }


def test_what_two_flipped_bits_can_make_dangerous_is_known() -> None:
    """No host can prevent these; they are why the protocol page says what a bad line can do."""
    _, changed = changed_requests(2)
    made_dangerous = {
        (f"{sent.command.name} {sent.data:02X}", f"{got.command.name} {got.data:02X}")
        for sent, got in changed
        if got.hazard is Hazard.DANGEROUS and sent.hazard is not Hazard.DANGEROUS
    }
    assert made_dangerous == {
        ("serial_output 01", "deploy 01"),
        ("serial_output 00", "shutdown 01"),
        ("activation 00", "activation 01"),
        ("activation 00", "deploy 00"),
        ("light_threshold 00", "deploy 00"),
        ("freefall_acceleration 00", "zero_sensor 00"),
        ("trigger_records 00", "zero_sensor 00"),
    }
