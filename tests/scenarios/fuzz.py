"""Nasty byte streams, and whether the stream parser and the reference decoder agree about them.

Every input is cut at random places, fed to the parser and compared: the same frames at the same places, every byte in
exactly one piece, never more than 15 bytes waiting.
"""

import random
import sys
from dataclasses import dataclass

from protocol.catalogue import BY_CODE, COMMANDS
from protocol.frame import Frame
from protocol.stream import Piece, StreamParser
from tests.support.line import reference_decoder
from tests.support.line.vectors import VALID

MOST_PENDING = 15
_FRAMES = tuple(vector.raw for vector in VALID)
_RECORD = next(raw for raw in _FRAMES if len(raw) == 16)
_CODES = tuple(BY_CODE)
_ASKED = (None, 0x32, 0x34, 0x35)
_FRAGMENTS = (b"A", b"B", b"Au", b"Ba", b"Au5\x01", b"Au5\x01\xca\x00", b"Au2", b"Ba\x34\x01", b"AuAu", b"AAu", b"BAu")


@dataclass(slots=True)
class Figures:
    """Counts of a run."""

    inputs: int = 0
    frames: int = 0
    disagreements: int = 0


def summed(head: bytes) -> bytes:
    """Return `head` (header, code, data) with its checksum."""
    return head + bytes((sum(head[2:]) & 0xFF,))


def hostile_bytes(source: random.Random) -> bytes:
    """Return frames that are whole, mutated, cut, nested or random, among garbage and pieces of headers."""
    return b"".join(_hostile_piece(source) for _ in range(source.randint(1, 6)))


def _hostile_piece(source: random.Random) -> bytes:
    kind = source.randrange(9)
    frame = source.choice(_FRAMES)
    if kind == 0:
        return frame
    if kind == 1:
        return source.randbytes(source.randint(1, 20))
    if kind == 2:
        return source.choice(_FRAGMENTS)
    if kind == 3:
        return frame[: source.randint(1, len(frame))]
    if kind == 4:
        return frame[source.randint(0, len(frame) - 1) :]
    if kind == 5:
        return _mutated(frame, source)
    if kind == 6:
        header = source.choice((b"Au", b"Ba"))
        body = bytes((source.choice(_CODES), source.choice((1, 2, 0xA5)), source.randrange(256)))
        return summed(header + body)
    if kind == 7:
        return summed(b"Au2" + bytes((*source.choices((0x41, 0x75, 7, 255), k=2), *source.choices((0, 1, 2), k=2))))
    return _hostile_record(source)


def _mutated(frame: bytes, source: random.Random) -> bytes:
    changed = bytearray(frame)
    for _ in range(source.randint(1, 3)):
        changed[source.randrange(len(changed))] ^= 1 << source.randrange(8)
    return bytes(changed)


def _hostile_record(source: random.Random) -> bytes:
    """Return a record that begins like a voltage, contains headers or a frame, is unused, or has a bad flag."""
    body = bytearray(_RECORD[4:15])
    kind = source.randrange(6)
    if kind in (0, 1):
        boot_count = source.randrange(256)
        body[:2] = boot_count, (0x36 + boot_count) & 0xFF
    if kind == 1:
        body[2:4] = source.choice((b"Au", b"Ba"))
    if kind == 2:
        body[:] = bytes((source.choice((0x00, 0xFF)),)) * len(body)
    if kind == 3:
        body[4:10] = next(raw for raw in iter(lambda: source.choice(_FRAMES), None) if len(raw) == 6)
    if kind == 4:
        body[source.randrange(len(body))] = source.randrange(256)
    raw = summed(b"Au5\x01" + bytes(body))
    return raw[: source.randint(4, 16)] if source.random() < 0.2 else raw


def parsed(data: bytes, parser: StreamParser, source: random.Random) -> list[Piece]:
    """Parse `data` in random cuts; raise `AssertionError` if the parser holds back too much."""
    pieces: list[Piece] = []
    at = 0
    while at < len(data):
        size = source.choice((1, 2, 3, 7, 16, 64, len(data)))
        pieces += parser.feed(data[at : at + size])
        at += size
        if parser.pending > MOST_PENDING:
            raise AssertionError(f"{parser.pending} bytes are pending")
    return pieces + parser.flush()


def agrees(data: bytes, asked: int | None, *, follows_host: bool, source: random.Random) -> int | None:
    """Return the count of frames that both decoders found, or None if they disagree or lose bytes."""
    command = next((one for one in COMMANDS if one.code == asked), None)
    parser = StreamParser(asked=None if command is None else command.query(), follows_host=follows_host)
    pieces = parsed(data, parser, source)
    found = [(piece.offset, piece.raw) for piece in pieces if isinstance(piece, Frame)]
    expected = reference_decoder.frames(data, asked=asked, follows_host=follows_host)
    is_whole = b"".join(piece.raw for piece in pieces) == data
    return len(found) if is_whole and found == expected else None


def fuzz(count: int, seed: int) -> Figures:
    """Compare the decoders on `count` inputs; print disagreements to standard error."""
    source = random.Random(seed)
    figures = Figures()
    for _ in range(count):
        data = hostile_bytes(source)
        asked = source.choice(_ASKED)
        follows_host = source.random() < 0.5
        found = agrees(data, asked, follows_host=follows_host, source=source)
        figures.inputs += 1
        if found is None:
            figures.disagreements += 1
            print(f"disagreement: asked {asked}, follows host {follows_host}: {data.hex(' ')}", file=sys.stderr)
        else:
            figures.frames += found
    return figures
