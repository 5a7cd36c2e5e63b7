"""Explains captured bytes: every frame and every run of invalid bytes."""

from collections.abc import Iterator
from typing import Final, NamedTuple

from app.captures.entries import CaptureEntry, Way
from app.captures.explain import Asked
from protocol.catalogue import DEFAULT_BAUD_RATE, Command
from protocol.frame import Direction, Frame, Noise, decode_request
from protocol.stream import Piece, StreamParser

QUIET_S: Final = 0.25
"""Silence after which a frame has ended."""
MAX_RUN_LENGTH: Final = 4096
"""Of invalid bytes in hex text; a longer run continues in the next row, so that memory stays bounded."""
_BYTE_S: Final = 10 / DEFAULT_BAUD_RATE


class Explained(NamedTuple):
    """A frame or a run of rejected bytes. `asked`: the request that a frame may answer."""

    at_s: float
    way: Way
    piece: Frame | Noise
    asked: Asked


class _Side:
    def __init__(self, way: Way) -> None:
        self.way = way
        self.parser = StreamParser()
        self.last_s = 0.0

    def flush(self, asked: Asked) -> list[Explained]:
        return [_row(self.last_s, self.way, piece, asked) for piece in self.parser.flush()]


class Explainer:
    """Entries in, pieces out: every byte is in exactly one of them. Each direction has its own parser."""

    is_timed = True

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
        return [*self._out.flush(self._asked), *self._in.flush(self._asked)]


class HexExplainer:
    """Bytes of both directions without times, of which the headers of frames tell the direction; noise counts as the
    module's. The rows do not depend on how the bytes were split; their times are those at the usual baud rate."""

    def __init__(self, asked: Command | None = None) -> None:
        query = asked.query() if asked is not None and asked.can_be_asked else None
        self._parser = StreamParser(asked=query, follows_host=True)
        self._asked: Asked = asked
        self._run: Noise | None = None

    def feed(self, data: bytes) -> list[Explained]:
        return list(self._rows(self._parser.feed(data)))

    def end(self) -> list[Explained]:
        return [*self._rows(self._parser.flush()), *self._end_of_run()]

    def _rows(self, pieces: list[Piece]) -> Iterator[Explained]:
        for piece in pieces:
            if isinstance(piece, Noise):
                yield from self._longer_run(piece)
                continue
            yield from self._end_of_run()
            is_request = piece.direction is Direction.HOST_TO_MODULE
            yield _row(piece.offset * _BYTE_S, Way.OUT if is_request else Way.IN, piece, self._asked)
            if is_request:
                self._asked = decode_request(piece.raw)

    def _longer_run(self, noise: Noise) -> Iterator[Explained]:
        run = self._run
        if run is not None and run.fault is noise.fault:
            noise = Noise(run.raw + noise.raw, noise.fault, run.offset)
        else:
            yield from self._end_of_run()
        for begin in range(0, len(noise.raw), MAX_RUN_LENGTH):
            if begin:
                yield from self._end_of_run()
            self._run = Noise(noise.raw[begin : begin + MAX_RUN_LENGTH], noise.fault, noise.offset + begin)

    def _end_of_run(self) -> list[Explained]:
        run, self._run = self._run, None
        return [] if run is None else [_row(run.offset * _BYTE_S, Way.IN, run, None)]


def _row(at_s: float, way: Way, piece: Piece, asked: Asked) -> Explained:
    return Explained(at_s, way, piece, asked if isinstance(piece, Frame) else None)
