"""Frames per second of the stream parser, in chunks as ports deliver them."""

import random
from collections.abc import Iterator
from itertools import product
from typing import Final

from protocol.messages import Frame, Status
from protocol.stream import StreamParser
from tests.bench.kit import LINE_HZ, Figure, best_s

AIM_TIMES: Final = 100


def stream(frames: int) -> bytes:
    """Status frames as of a module in flight."""
    dice = random.Random(1)
    statuses = (
        Status(dice.randint(0, 90), dice.randint(0, 30) / 10, triggered=False, active=True) for _ in range(frames)
    )
    return b"".join(status.encode() for status in statuses)


def corrupted(data: bytes, share: float) -> bytes:
    """The same with one flipped bit in this share of the bytes."""
    dice = random.Random(2)
    return bytes(byte ^ (1 << dice.randrange(8)) if dice.random() < share else byte for byte in data)


def parse(chunks: list[bytes]) -> int:
    """Return the frames found. Every byte is in one of them, or rejected with a reason."""
    parser, frames, covered = StreamParser(), 0, 0
    for chunk in [*chunks, b""]:
        for piece in parser.feed(chunk) if chunk else parser.flush():
            covered += len(piece.raw)
            frames += isinstance(piece, Frame)
    assert covered == sum(map(len, chunks)), "bytes went missing"
    return frames


def figures(frames: int = 100_000, rounds: int = 7) -> Iterator[Figure]:
    """The aim applies to blocks as from a file or a busy port."""
    clean = stream(frames)
    kinds = {"clean": clean, "1 % of bytes corrupted": corrupted(clean, 0.01)}
    for (name, data), size in product(kinds.items(), (4096, 64, 1)):
        part = data if size > 1 else data[: len(data) // 8]
        chunks = [part[at : at + size] for at in range(0, len(part), size)]
        per_s = parse(chunks) / best_s(lambda chunks=chunks: parse(chunks), rounds)  # type: ignore[misc]
        times = per_s / LINE_HZ
        aim = (f">= {AIM_TIMES:,} x line", times >= AIM_TIMES) if size == 4096 and data is clean else ()
        yield Figure(f"parser, {name}, {size} bytes at a time", f"{per_s:,.0f} frames/s, {times:,.0f} x line", *aim)
