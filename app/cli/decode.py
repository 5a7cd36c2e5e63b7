"""`dps-s decode`: explains captured bytes. Every byte belongs to exactly one line of the output, in order.

    dps-s decode 41 75 32 07 0A 00 01 44          bytes as arguments
    dps-s decode --json - < capture.txt           hex text from standard input, explained while it comes

Exit code 0; 2 for text that is not hex; 4 where some bytes were no frame.
"""

import argparse
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

from app.captures.explain import Asked, meaning, sentence
from app.terminal import console
from app.text.hex_text import HexText, NotHex
from app.text.i18n import tr
from app.text.sentences import listed
from app.trigger_records.fields import JsonValue
from protocol.catalogue import BY_NAME, Command
from protocol.frame import Direction, Frame, Noise, decode_request
from protocol.stream import Piece, StreamParser

LONGEST_RUN = 4096
"""Rejected bytes in one line at most; a longer run goes on in the next line, so that memory stays bounded."""
SHOWN_BYTES = 16
"""Bytes that a line for people shows: the longest frame."""
_READ_CHARACTERS = 65536


@dataclass(frozen=True, slots=True)
class DecodedLine:
    """One frame or one run of rejected bytes, and what was asked when it came."""

    piece: Piece
    asked: Asked


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = subparsers.add_parser(
        "decode",
        help=tr("explain captured bytes"),
        description=tr(
            "Explain captured bytes. What was asked is taken from the host's frames in the capture, else from --asked; "
            "with neither, a whole trigger record of 16 bytes wins over a reply of six."
        ),
    )
    parser.add_argument("hex", nargs="*", metavar="HEX", help=tr("bytes in hex; - reads hex text from standard input"))
    parser.add_argument(
        "--asked",
        metavar="NAME",
        choices=sorted(BY_NAME),
        help=tr("the command that the module's frames answer: {names}", names=listed(BY_NAME)),
    )
    console.add_json_argument(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    words: list[str] = args.hex
    if not words:
        return _refuse(tr("Nothing to decode: give the bytes in hex, or - to read them from standard input."))
    asked = BY_NAME[args.asked] if args.asked else None
    pieces = _bytes_of_input() if words == ["-"] else _bytes_of_words(words)
    try:
        return _print_all(pieces, asked, _json_text if args.json else _text_for_people)
    except NotHex as error:
        return _refuse(
            tr("“{word}” is no pair of hex digits; bytes look like 41 75 32, 417532 or 0x41,0x75.", word=error.word)
        )
    except UnicodeDecodeError:
        return _refuse(tr("Standard input is not text; decode reads bytes written in hex, such as 41 75 32."))


def _print_all(data: Iterable[bytes], asked: Command | None, text_of: Callable[[DecodedLine], str]) -> int:
    capture = CaptureDecoder(asked)
    has_rejected = False
    for lines in chain(map(capture.feed, data), (capture.finish(),)):
        texts = []
        for line in lines:
            has_rejected |= isinstance(line.piece, Noise)
            texts.append(text_of(line))
        console.write_lines(texts)
    return console.PARTLY if has_rejected else console.DONE


class CaptureDecoder:
    """Bytes of a capture in, lines out; how the bytes were cut into pieces does not show in the lines."""

    def __init__(self, asked: Command | None = None) -> None:
        query = asked.query() if asked is not None and asked.can_be_asked else None
        self._parser = StreamParser(asked=query, follows_host=True)
        self._asked: Asked = asked
        self._run: Noise | None = None

    def feed(self, data: bytes) -> Iterator[DecodedLine]:
        return self._lines(self._parser.feed(data))

    def finish(self) -> Iterator[DecodedLine]:
        """The lines of what still waited for more."""
        yield from self._lines(self._parser.flush())
        yield from self._end_of_run()

    def _lines(self, pieces: list[Piece]) -> Iterator[DecodedLine]:
        for piece in pieces:
            if isinstance(piece, Noise):
                yield from self._longer_run(piece)
                continue
            yield from self._end_of_run()
            yield DecodedLine(piece, self._asked)
            if piece.direction is Direction.HOST_TO_MODULE:
                self._asked = decode_request(piece.raw)

    def _longer_run(self, noise: Noise) -> Iterator[DecodedLine]:
        run = self._run
        if run is not None and run.fault is not noise.fault:
            yield from self._end_of_run()
            run = None
        if run is not None:
            noise = Noise(run.raw + noise.raw, run.fault, run.offset)
        raw, offset = noise.raw, noise.offset
        while len(raw) > LONGEST_RUN:
            yield DecodedLine(Noise(raw[:LONGEST_RUN], noise.fault, offset), self._asked)
            raw, offset = raw[LONGEST_RUN:], offset + LONGEST_RUN
        self._run = Noise(raw, noise.fault, offset)

    def _end_of_run(self) -> Iterator[DecodedLine]:
        if self._run is not None:
            yield DecodedLine(self._run, self._asked)
            self._run = None


def as_json(line: DecodedLine) -> dict[str, JsonValue]:
    """The object of one line of `decode --json`; always in English."""
    piece = line.piece
    place: dict[str, JsonValue] = {"offset": piece.offset, "hex": _hex(piece.raw), "valid": isinstance(piece, Frame)}
    if isinstance(piece, Noise):
        return place | {"reason": piece.detail}
    return place | {"direction": piece.direction.value} | meaning(piece, line.asked)


def _json_text(line: DecodedLine) -> str:
    return console.as_json(as_json(line))


def _text_for_people(line: DecodedLine) -> str:
    piece = line.piece
    if isinstance(piece, Noise):
        sender = "-"
    else:
        sender = tr("host") if piece.direction is Direction.HOST_TO_MODULE else tr("module")
    shown = _hex(piece.raw[:SHOWN_BYTES])
    words = sentence(piece, line.asked)
    if len(piece.raw) > SHOWN_BYTES:
        words = tr("… {count} bytes: {words}", count=len(piece.raw), words=words)
    return f"{piece.offset:6}  {sender:6}  {shown:{3 * SHOWN_BYTES - 1}}  {words}"


def _bytes_of_words(words: list[str]) -> Iterator[bytes]:
    """All at once: a word that is no hex is refused before anything is printed."""
    text = HexText()
    data = text.feed(" ".join(words))
    text.finish()
    yield data


def _bytes_of_input() -> Iterator[bytes]:
    """Standard input line by line, as it comes; a line without an end in pieces."""
    text = HexText()
    while characters := sys.stdin.readline(_READ_CHARACTERS):
        yield text.feed(characters)
    text.finish()


def _hex(raw: bytes) -> str:
    return raw.hex(" ").upper()


def _refuse(reason: str) -> int:
    console.say(reason)
    return console.USED_WRONGLY
