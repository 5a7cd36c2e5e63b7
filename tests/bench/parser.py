"""Frames per second of the stream parser, in chunks as ports deliver them, against what others write."""

import gc
import random
import time
from collections.abc import Callable
from itertools import product
from typing import Final

import construct

from protocol.frame import Frame
from protocol.messages import Status
from protocol.stream import StreamParser
from tests.bench.figures import Figure

LINE_HZ: Final = 1440
"""Status frames per second at 115200 baud."""
AIM_TIMES: Final = 1000
_STATUS: Final = construct.Struct(
    "header" / construct.Const(b"Au"),
    "body"
    / construct.RawCopy(
        construct.Struct(
            "code" / construct.Const(b"\x32"),
            "tilt_deg" / construct.Byte,
            "tenth_g" / construct.Byte,
            "triggered" / construct.Flag,
            "active" / construct.Flag,
        )
    ),
    "checksum" / construct.Checksum(construct.Byte, lambda data: sum(data) & 0xFF, construct.this.body.data),
)


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


def parse(chunks: list[bytes]) -> int:
    """The frames found. Raises `AssertionError` unless every byte is in a frame or rejected with a reason."""
    parser = StreamParser()
    frames = covered = 0
    for chunk in chunks:
        for piece in parser.feed(chunk):
            covered += len(piece.raw)
            frames += piece.__class__ is Frame
    for piece in parser.flush():
        covered += len(piece.raw)
        frames += piece.__class__ is Frame
    assert covered == sum(map(len, chunks)), "bytes went missing"
    return frames


def parse_with_construct(chunks: list[bytes]) -> int:
    """Declared with `construct`; skips one byte where parsing fails; the status frames found."""
    buffer, frames = b"", 0
    for chunk in chunks:
        buffer += chunk
        at = 0
        while len(buffer) - at >= 8:
            at = buffer.find(b"Au", at)
            if at < 0 or len(buffer) - at < 8:
                break
            try:
                _STATUS.parse(buffer[at : at + 8])
            except construct.ConstructError:
                at += 1
            else:
                frames += 1
                at += 8
        buffer = buffer[at if at >= 0 else max(0, len(buffer) - 1) :]
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


def figures(frames: int = 100_000, rounds: int = 7) -> list[Figure]:
    """One row per chunk size. The aim applies to blocks as from a file or a busy port."""
    clean, found = stream(frames), []
    for (name, data), size in product(
        (("clean", clean), ("1 % of bytes corrupted", corrupted(clean, 0.01))), (4096, 64, 1)
    ):
        part = data if size > 1 else data[: len(data) // 8]
        chunks = [part[at : at + size] for at in range(0, len(part), size)]
        mine = _frames_per_s(parse, chunks, rounds)
        declared = _frames_per_s(parse_with_construct, chunks[: len(chunks) // 10 or 1], 1)
        times = mine / LINE_HZ
        found.append(
            Figure(
                f"parser, {name}, {size} byte{'s' if size > 1 else ''} at a time",
                f"{mine:,.0f} frames/s, {times:,.0f} x line, {mine / declared:.0f} x construct",
                *((f">= {AIM_TIMES:,} x line", times >= AIM_TIMES) if size == 4096 and data is clean else ()),
            )
        )
    return found
