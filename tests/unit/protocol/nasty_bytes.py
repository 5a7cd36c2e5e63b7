"""Byte streams as nasty as a line can make them."""

import random

from protocol.catalogue import BY_CODE
from tests.vendor.frames import VALID

_FRAMES = tuple(vector.raw for vector in VALID)
_RECORD = next(raw for raw in _FRAMES if len(raw) == 16)
_CODES = tuple(BY_CODE)
_FRAGMENTS = (b"A", b"B", b"Au", b"Ba", b"Au5\x01", b"Au5\x01\xca\x00", b"Au2", b"Ba\x34\x01", b"AuAu", b"AAu", b"BAu")


def summed(head: bytes) -> bytes:
    """Return `head` (header, code, data) with its checksum."""
    return head + bytes((sum(head[2:]) & 0xFF,))


def hostile_bytes(source: random.Random) -> bytes:
    """Return frames that are whole, mutated, cut, nested or random, among garbage and pieces of headers."""
    return b"".join(_hostile_piece(source) for _ in range(source.randint(1, 6)))


def _hostile_piece(source: random.Random) -> bytes:
    frame, cut = source.choice(_FRAMES), source.randint(0, 5)
    match source.randrange(9):
        case 0:
            return frame
        case 1:
            return source.randbytes(source.randint(1, 20))
        case 2:
            return source.choice(_FRAGMENTS)
        case 3:
            return frame[: cut + 1]
        case 4:
            return frame[cut:]
        case 5:
            changed = bytearray(frame)
            for _ in range(source.randint(1, 3)):
                changed[source.randrange(len(changed))] ^= 1 << source.randrange(8)
            return bytes(changed)
        case 6:
            body = bytes((source.choice(_CODES), source.choice((1, 2, 0xA5)), source.randrange(256)))
            return summed(source.choice((b"Au", b"Ba")) + body)
        case 7:
            values = (*source.choices((0x41, 0x75, 7, 255), k=2), *source.choices((0, 1, 2), k=2))
            return summed(b"Au2" + bytes(values))
    return _hostile_record(source)


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
