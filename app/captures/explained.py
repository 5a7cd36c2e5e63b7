"""Explains a capture entry by entry: every frame and every run of invalid bytes."""

from typing import Final, NamedTuple

from app.captures.entries import CaptureEntry, Way
from app.captures.explain import Asked
from protocol.catalogue import Command
from protocol.frame import Direction, Frame, Noise, decode_request
from protocol.stream import Piece, StreamParser

QUIET_S: Final = 0.25
"""Silence after which a frame has ended."""


class Explained(NamedTuple):
    """A frame or a run of rejected bytes. `asked`: the request that a frame may answer."""

    at_s: float
    way: Way
    piece: Frame | Noise
    asked: Asked


class _Side:
    """One direction."""

    def __init__(self, way: Way) -> None:
        self.way = way
        self.parser = StreamParser()
        self.last_s = 0.0

    def flush(self, asked: Asked) -> list[Explained]:
        return [_row(self.last_s, self.way, piece, asked) for piece in self.parser.flush()]


class Explainer:
    """Entries in, pieces out: every byte is in exactly one of them. Each direction has its own parser."""

    def __init__(self, asked: Command | None = None) -> None:
        """`asked`: the command that the module's frames answer until the first request."""
        self._out, self._in = _Side(Way.OUT), _Side(Way.IN)
        self._asked: Asked = asked
        self._in.parser.asked = asked.query() if asked is not None and asked.can_be_asked else None

    def feed(self, entry: CaptureEntry) -> list[Explained]:
        """The pieces that the entry completes, or the silence before it ended."""
        at_s, way, raw = entry
        rows: list[Explained] = []
        for side in (self._out, self._in):
            if at_s - side.last_s >= QUIET_S and side.parser.pending:
                rows += side.flush(self._asked)
        if way is Way.OUT:
            self._out.last_s = at_s
            for piece in self._out.parser.feed(raw):
                rows.append(_row(at_s, way, piece, self._asked))
                if isinstance(piece, Frame) and piece.direction is Direction.HOST_TO_MODULE:
                    self._asked = self._in.parser.asked = decode_request(piece.raw)
        else:
            self._in.last_s = at_s
            asked = self._asked
            rows += [_row(at_s, way, piece, asked) for piece in self._in.parser.feed(raw)]
        return rows

    def end(self) -> list[Explained]:
        """The pieces that are left at the end of the capture."""
        return [*self._out.flush(self._asked), *self._in.flush(self._asked)]


def _row(at_s: float, way: Way, piece: Piece, asked: Asked) -> Explained:
    return Explained(at_s, way, piece, asked if isinstance(piece, Frame) else None)
