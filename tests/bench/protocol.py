"""The stream parser and the link, without a port."""

import random
from collections.abc import Iterator
from itertools import product
from typing import Final

from protocol.catalogue import BY_NAME
from protocol.events import Answered
from protocol.link import Link
from protocol.messages import Frame, Status, encode_reply
from protocol.stream import StreamParser
from tests.bench.kit import LINE_HZ, Figure, best_s

PARSER_AIM: Final = 100  # times as quick as the line
LINK_AIM: Final = 10
# Exchanges of six bytes each way per second at 115200 baud.
LINE_EXCHANGES: Final = 11_520 // 12


def _parse(chunks: list[bytes]) -> int:
    """Return the frames found. Every byte is in one of them, or rejected with a reason."""
    parser, frames, covered = StreamParser(), 0, 0
    for chunk in [*chunks, b""]:
        for piece in parser.feed(chunk) if chunk else parser.flush():
            covered += len(piece.raw)
            frames += isinstance(piece, Frame)
    assert covered == sum(map(len, chunks)), "bytes went missing"
    return frames


def parser(frames: int = 100_000, rounds: int = 7) -> Iterator[Figure]:
    """Frames per second of the stream parser, in chunks as ports deliver them. The aim applies to blocks as from a file
    or a busy port."""
    dice = random.Random(1)
    clean = b"".join(
        Status(dice.randint(0, 90), dice.randint(0, 30) / 10, triggered=False, active=True).encode()
        for _ in range(frames)
    )
    worn = bytes(byte ^ (1 << dice.randrange(8)) if dice.random() < 0.01 else byte for byte in clean)
    for (name, data), size in product((("clean", clean), ("1 % of bytes corrupted", worn)), (4096, 64, 1)):
        part = data if size > 1 else data[: len(data) // 8]
        chunks = [part[at : at + size] for at in range(0, len(part), size)]
        per_s = _parse(chunks) / best_s(lambda chunks=chunks: _parse(chunks), rounds)  # type: ignore[misc]
        times = per_s / LINE_HZ
        aim = (f">= {PARSER_AIM} x line", times >= PARSER_AIM) if size == 4096 and data is clean else ()
        yield Figure(f"parser, {name}, {size} bytes at a time", f"{per_s:,.0f} frames/s, {times:,.0f} x line", *aim)


def link(exchanges: int = 20_000, rounds: int = 5) -> Iterator[Figure]:
    """Cost of one exchange in the link."""
    query, reply = BY_NAME["boot_count"].query(), encode_reply(0x23, 37)

    def exchange() -> None:
        made, now = Link(0.0), 0.001
        made.tick(0.0)  # the link asks for the boot count itself, with which a conversation begins
        made.receive(reply, now)
        assert made.is_begun
        for _ in range(exchanges):
            made.ask(query, now)
            now += 0.001
            assert any(isinstance(event, Answered) for event in made.receive(reply, now))
            now += 0.001

    took_s = best_s(exchange, rounds) / exchanges
    times = 1 / took_s / LINE_EXCHANGES
    measured = f"{took_s * 1e6:.0f} µs, {times:.0f} x line"
    yield Figure("link, a question and its answer", measured, f">= {LINK_AIM} x line", times >= LINK_AIM)
