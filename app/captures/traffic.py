"""Traffic: bytes on the line with their time and direction, the frames in them, and how both are read from text.

A text has lines with times, as in support bundles: "0.002913 < 41 75 32 07 0A 00 01 44". A line that cannot be read is
skipped and reported. Any other text is hex as people paste it, also with commas and "0x". Lines that begin with # are
remarks.
"""

import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import partial
from itertools import groupby
from operator import itemgetter
from typing import Final, NamedTuple, TextIO

from app.captures.explain import Asked
from protocol.catalogue import Command
from protocol.events import Event, Received, Rejected, Sent
from protocol.messages import Direction, Frame, Noise, decode_request
from protocol.stream import Piece, StreamParser

# After such a silence a frame has ended.
QUIET_S: Final = 0.25


# As text has them.
_SIGNS: Final = {">": Direction.HOST_TO_MODULE, "<": Direction.MODULE_TO_HOST}


class CaptureEntry(NamedTuple):
    """Bytes that were sent or received together. `at_s`: seconds since the capture began."""

    at_s: float
    direction: Direction
    raw: bytes

    @property
    def line(self) -> str:
        """As `app.captures.traffic` reads it."""
        sign = ">" if self.direction is Direction.HOST_TO_MODULE else "<"
        return f"{self.at_s:.6f} {sign} {self.raw.hex(' ').upper()}"


def entries_of(events: Iterable[Event], started_at: float) -> Iterator[CaptureEntry]:
    """The bytes of these events; those of one moment and direction are one entry. `started_at`: monotonic time that
    becomes 0, also for earlier events."""
    pieces = filter(None, map(_piece_of, events))
    for (at, direction), together in groupby(pieces, key=itemgetter(0, 1)):
        yield CaptureEntry(max(0.0, at - started_at), direction, b"".join(raw for _, _, raw in together))


def _piece_of(event: Event) -> tuple[float, Direction, bytes] | None:
    match event:
        case Received():
            return event.at, Direction.MODULE_TO_HOST, event.frame.raw
        case Rejected():
            return event.at, Direction.MODULE_TO_HOST, event.noise.raw
        case Sent():
            return event.at, Direction.HOST_TO_MODULE, event.raw
        case _:
            return None


class Explained(NamedTuple):
    """A frame or a run of rejected bytes. `asked`: the request that a frame may answer. `at_s` None: of bytes without
    times, where only the header of a frame tells its direction."""

    at_s: float | None
    direction: Direction
    piece: Frame | Noise
    asked: Asked


class Explainer:
    """Bytes in, pieces out: every byte is in exactly one of them."""

    def __init__(self, asked: Command | None = None) -> None:
        """`asked`: the command that the module's frames answer until the first request."""
        self._asked: Asked = asked
        query = asked.query() if asked is not None and asked.can_be_asked else None
        # Each direction has its own parser, so frames that crossed on the wire stay whole.
        self._parsers = {Direction.HOST_TO_MODULE: StreamParser(), Direction.MODULE_TO_HOST: StreamParser(asked=query)}
        self._last_s = dict.fromkeys(Direction, 0.0)
        # Of bytes without direction, whose frames tell it by their headers.
        self._mixed = StreamParser(asked=query, follows_host=True)

    def feed(self, entry: CaptureEntry) -> list[Explained]:
        """The pieces that the entry completes, or the silence before it ended."""
        at_s, direction, raw = entry
        rows: list[Explained] = []
        for side, parser in self._parsers.items():
            if at_s - self._last_s[side] >= QUIET_S and parser.pending:
                rows += self._rows(parser.flush(), self._last_s[side], side)
        self._last_s[direction] = at_s
        return rows + self._rows(self._parsers[direction].feed(raw), at_s, direction)

    def feed_untimed(self, raw: bytes) -> list[Explained]:
        # The pieces in bytes of both directions without times; noise counts as the module's.
        return self._rows(self._mixed.feed(raw), None)

    def end(self) -> list[Explained]:
        rows = []
        for direction, parser in self._parsers.items():
            rows += self._rows(parser.flush(), self._last_s[direction], direction)
        return rows + self._rows(self._mixed.flush(), None)

    def _rows(self, pieces: list[Piece], at_s: float | None, direction: Direction | None = None) -> list[Explained]:
        rows = []
        for piece in pieces:
            own = piece.direction if isinstance(piece, Frame) else Direction.MODULE_TO_HOST
            rows.append(Explained(at_s, direction or own, piece, self._asked if isinstance(piece, Frame) else None))
            # No echo of a request changes what was asked.
            if own is Direction.HOST_TO_MODULE and direction is not Direction.MODULE_TO_HOST:
                self._asked = self._parsers[Direction.MODULE_TO_HOST].asked = decode_request(piece.raw)
        return rows


MAX_LINE: Final = 1 << 22  # characters; a longer line is read in pieces
MAX_FAULTS: Final = 100
_ENTRY = re.compile(r"(\d{1,12}(?:\.\d{1,9})?)\s+([<>])\s*(.*)")
_PAIRS = re.compile(r"(?:[0-9a-fA-F]{2})+")


class NotHex(ValueError):
    """A word that is no pairs of hex digits; as text its beginning."""


def hex_bytes(text: str) -> bytes:
    """The bytes of words of whole pairs of digits. Raises `NotHex`."""
    words = re.sub(r"\b0[xX]|[,\ufeff]", " ", text).split()
    try:
        return bytes.fromhex(" ".join(words))
    except ValueError:
        raise NotHex(next(word[:24] for word in words if not _PAIRS.fullmatch(word))) from None


class TextReader:
    """Explains text line by line; its first line that is no remark tells whether it has times."""

    def __init__(self, asked: Command | None = None) -> None:
        """`asked`: as of `Explainer`."""
        # Of lines that were skipped in a text with times, the numbers from 1: the first `MAX_FAULTS`.
        self.faults: list[int] = []
        self._explainer = Explainer(asked)
        self._is_timed: bool | None = None
        self._number = 0

    def feed(self, line: str) -> list[Explained]:
        """Take a line, and return what it completes. Raises `NotHex` where the text has no times."""
        self._number += 1
        plain = line.strip("\ufeff \t\r\n")
        if not plain or plain.startswith("#"):
            return []
        found = _ENTRY.fullmatch(plain)
        if self._is_timed is None:
            self._is_timed = found is not None
        if not self._is_timed:
            return self._explainer.feed_untimed(hex_bytes(plain))
        if found is not None:
            with suppress(NotHex):
                return self._explainer.feed(CaptureEntry(float(found[1]), _SIGNS[found[2]], hex_bytes(found[3])))
        if len(self.faults) < MAX_FAULTS:
            self.faults.append(self._number)
        return []

    def end(self) -> list[Explained]:
        return self._explainer.end()


def lines_in(file: TextIO) -> Iterator[str]:
    return iter(partial(file.readline, MAX_LINE), "")
