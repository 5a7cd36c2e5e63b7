"""Frames per second of the stream parser, in chunks as ports deliver them, compared with alternatives."""

import gc
import random
import time
from collections.abc import Callable
from typing import Final

from protocol.frame import Frame, Noise
from protocol.messages import Status
from protocol.stream import StreamParser
from tests.benchmarks.figures import Figure
from tests.benchmarks.others import parse_bytewise, parse_with_construct

LINE_HZ: Final = 1440
"""Status frames per second at 115200 baud."""
AIM_TIMES: Final = 1000
_ROUNDS: Final = 7
_CORRUPT: Final = 0.01


def stream(frames: int) -> bytes:
    """Status frames as of a module in flight."""
    source = random.Random(1)
    statuses = (
        Status(source.randint(0, 90), source.randint(0, 30) / 10, triggered=False, active=True) for _ in range(frames)
    )
    return b"".join(status.encode() for status in statuses)


def corrupted(data: bytes, share: float) -> bytes:
    """The same with one flipped bit in this share of the bytes."""
    source = random.Random(2)
    return bytes(byte ^ (1 << source.randrange(8)) if source.random() < share else byte for byte in data)


def _chunks(data: bytes, size: int) -> list[bytes]:
    return [data[at : at + size] for at in range(0, len(data), size)]


def _parse(chunks: list[bytes]) -> int:
    """Number of frames. Raises `AssertionError` unless every byte is in a frame or rejected with a reason."""
    parser = StreamParser()
    frames = covered = 0
    for chunk in chunks:
        for piece in parser.feed(chunk):
            covered += len(piece.raw)
            frames += piece.__class__ is Frame
    for piece in parser.flush():
        covered += len(piece.raw)
        frames += not isinstance(piece, Noise)
    if covered != sum(map(len, chunks)):
        raise AssertionError("bytes went missing")
    return frames


def _frames_per_s(parse: Callable[[list[bytes]], int], chunks: list[bytes], rounds: int) -> float:
    """Of the best round; slower rounds are due to other load."""
    best_s, frames = float("inf"), 0
    gc.collect()
    for _ in range(rounds):
        began = time.perf_counter()
        frames = parse(chunks)
        best_s = min(best_s, time.perf_counter() - began)
    return frames / best_s


def figures(frames: int = 100_000, rounds: int = _ROUNDS) -> list[Figure]:
    """One row per chunk size. The aim applies to blocks as from a file or a busy port."""
    clean = stream(frames)
    found = []
    for name, data in (("clean", clean), ("1 % of bytes corrupted", corrupted(clean, _CORRUPT))):
        for size in (4096, 64, 1):
            chunks = _chunks(data if size > 1 else data[: len(data) // 8], size)
            mine = _frames_per_s(_parse, chunks, rounds)
            naive = _frames_per_s(parse_bytewise, chunks, min(2, rounds))
            declared = _frames_per_s(parse_with_construct, chunks[: len(chunks) // 10 or 1], 1)
            times = mine / LINE_HZ
            has_aim = size == 4096 and data is clean
            found.append(
                Figure(
                    f"parser, {name}, {size} byte{'s' if size > 1 else ''} at a time",
                    f"{mine:,.0f} frames/s, {times:,.0f} x line, {mine / naive:.1f} x naive loop, "
                    f"{mine / declared:.0f} x construct",
                    f">= {AIM_TIMES:,} x line" if has_aim else "",
                    times >= AIM_TIMES if has_aim else None,
                )
            )
    return found
