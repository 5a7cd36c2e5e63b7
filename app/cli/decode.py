"""`dps-s decode`: explains captured bytes. Every byte belongs to exactly one line of the output, in order.

    dps-s decode 41 75 32 07 0A 00 01 44          bytes as arguments
    dps-s decode session.mcap                     a session of this program, or a file of hex text
    dps-s decode --json - < capture.txt           either of them from standard input, as it arrives

In a capture each direction is decoded by itself, so frames that crossed on the wire stay whole; `offset` counts the
bytes of that direction, and each line has its time. Exit code 0; 2 for text that is neither; 4 if some bytes were no
frame, or lines of the file could not be read.
"""

import argparse
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from app.captures.entries import Way
from app.captures.explain import Asked, meaning, sentence
from app.captures.explained import Explained, Explainer
from app.captures.reader import ENTRY_LINE, MAGIC_LINE, MAX_LINE_LENGTH, CaptureReader, CaptureRefused
from app.terminal import console
from app.text.hex_text import HexText, NotHex
from app.text.i18n import tr
from app.text.sentences import error_text
from app.trigger_records.fields import JsonValue
from protocol.catalogue import BY_NAME, Command
from protocol.frame import Direction, Frame, Noise, decode_request
from protocol.stream import Piece, StreamParser

EXAMPLE = "41 75 32"
MAX_RUN_LENGTH = 4096
"""Maximum of rejected bytes in one line; a longer run continues in the next line, so that memory stays bounded."""
SHOWN_BYTES = 16
"""Bytes that a line for people shows: the length of the longest frame."""
LINES_AT_ONCE = 500
"""Of a file; standard input and pipes are printed line by line."""
_READ_CHARACTERS = MAX_LINE_LENGTH + 1
_DIRECTIONS = {Way.OUT: Direction.HOST_TO_MODULE, Way.IN: Direction.MODULE_TO_HOST}


@dataclass(frozen=True, slots=True)
class DecodedLine:
    """A frame or a run of rejected bytes, and the request that it may answer."""

    piece: Piece
    asked: Asked
    at_s: float | None = None
    """In a capture: seconds since its beginning."""
    way: Way | None = None
    """In a capture: the direction of the bytes."""


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = subparsers.add_parser("decode")
    parser.add_argument("hex", nargs="*", metavar="HEX", help=tr("hex bytes, a capture, or - for standard input"))
    parser.add_argument("--asked", metavar="NAME", choices=sorted(BY_NAME),
                        help=", ".join(BY_NAME))  # fmt: skip
    console.add_json_argument(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    words: list[str] = args.hex
    if not words:
        raise console.Refused(tr("expected {expected}", expected=f"{EXAMPLE}, FILE, -"))
    asked = BY_NAME[args.asked] if args.asked else None
    printer = _Printer(_json_text if args.json else _text_for_people)
    try:
        if words == ["-"]:
            _decode_text(iter(lambda: sys.stdin.readline(_READ_CHARACTERS), ""), asked, printer)
        elif len(words) == 1 and not _is_hex(words[0]) and _names_file(words[0]):
            path = Path(words[0])
            if path.suffix.lower() == ".mcap":
                return _decode_session(path, asked, printer)
            at_once = LINES_AT_ONCE if path.is_file() else 1
            with path.open(encoding="utf-8-sig") as file:
                _decode_text(iter(lambda: file.readline(_READ_CHARACTERS), ""), asked, printer, at_once=at_once)
        else:
            _decode_hex(_bytes_of_arguments(words), asked, printer)
    except NotHex as error:
        raise console.Refused(tr("{word}: neither hex nor a file", word=error.word)) from error
    except UnicodeDecodeError as error:
        raise console.Refused(tr("{word}: neither hex nor a file", word=words[0])) from error
    except CaptureRefused as error:
        text = str(error)
        raise console.Refused(tr(text)) from error
    except BrokenPipeError:
        raise
    except OSError as error:
        raise console.Refused(tr("{file} cannot be read: {why}.", file=words[0], why=error_text(error))) from error
    return console.PARTIAL if printer.has_rejected else console.SUCCESS


class _Printer:
    """Prints decoded lines."""

    def __init__(self, text_of: Callable[[DecodedLine], str]) -> None:
        self._text_of = text_of
        self.has_rejected = False

    def print(self, lines: Iterable[DecodedLine]) -> None:
        texts = []
        for line in lines:
            self.has_rejected |= isinstance(line.piece, Noise)
            texts.append(self._text_of(line))
        console.write_lines(texts)


def _decode_session(path: Path, asked: Command | None, printer: "_Printer") -> int:
    from app.recordings.library import entry_of
    from app.recordings.recording import traffic_of
    from app.recordings.session_format import Unreadable

    explainer, waiting = Explainer(asked), list[Explained]()
    entry = entry_of(path)
    try:
        for item in traffic_of(entry):
            waiting += explainer.feed(item)
            if len(waiting) >= LINES_AT_ONCE:
                printer.print(map(_line_of, waiting))
                waiting.clear()
    except Unreadable as error:
        why = str(error)
        raise console.Refused(tr("{file} cannot be read: {why}.", file=path, why=tr(why))) from error
    printer.print(map(_line_of, [*waiting, *explainer.end()]))
    return console.PARTIAL if printer.has_rejected else console.SUCCESS


def _decode_text(lines: Iterator[str], asked: Command | None, printer: _Printer, *, at_once: int = 1) -> None:
    """The first line that is not empty decides between capture and hex text. Prints every `at_once` lines."""
    first = next((line for line in lines if line.strip()), "").removeprefix("\ufeff")
    if MAGIC_LINE.fullmatch(first.strip()) or ENTRY_LINE.fullmatch(first.strip()):
        _decode_capture(chain((first,), lines), asked, printer, at_once)
    else:
        _decode_hex(_bytes_of_text(chain((first,), lines)), asked, printer)


def _decode_capture(lines: Iterator[str], asked: Command | None, printer: _Printer, at_once: int) -> None:
    reader, explainer = CaptureReader(), Explainer(asked)
    waiting: list[Explained] = []
    for number, line in enumerate(lines, start=1):
        goes_on = len(line) >= _READ_CHARACTERS and not line.endswith("\n")
        for entry in reader.feed(line, goes_on=goes_on):
            waiting += explainer.feed(entry)
        if number % at_once == 0:
            printer.print(map(_line_of, waiting))
            waiting.clear()
    printer.print(map(_line_of, [*waiting, *explainer.end()]))
    for fault in reader.faults:
        console.notify(tr("Line {number} is left out: {why}.", number=fault.line, why=tr(fault.text)))
    printer.has_rejected |= bool(reader.faults)


def _line_of(row: Explained) -> DecodedLine:
    return DecodedLine(row.piece, row.asked, row.at_s, row.way)


def _decode_hex(data: Iterable[bytes], asked: Command | None, printer: _Printer) -> None:
    capture = CaptureDecoder(asked)
    for lines in chain(map(capture.feed, data), (capture.finish(),)):
        printer.print(lines)


class CaptureDecoder:
    """Bytes of both directions in, lines out; the lines do not depend on how the bytes were split."""

    def __init__(self, asked: Command | None = None) -> None:
        query = asked.query() if asked is not None and asked.can_be_asked else None
        self._parser = StreamParser(asked=query, follows_host=True)
        self._asked: Asked = asked
        self._run: Noise | None = None

    def feed(self, data: bytes) -> Iterator[DecodedLine]:
        return self._lines(self._parser.feed(data))

    def finish(self) -> Iterator[DecodedLine]:
        """The lines of the bytes that are left."""
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
        while len(raw) > MAX_RUN_LENGTH:
            yield DecodedLine(Noise(raw[:MAX_RUN_LENGTH], noise.fault, offset), self._asked)
            raw, offset = raw[MAX_RUN_LENGTH:], offset + MAX_RUN_LENGTH
        self._run = Noise(raw, noise.fault, offset)

    def _end_of_run(self) -> Iterator[DecodedLine]:
        if self._run is not None:
            yield DecodedLine(self._run, self._asked)
            self._run = None


def as_json(line: DecodedLine) -> dict[str, JsonValue]:
    """The object of one line of `decode --json`; always in English."""
    piece = line.piece
    place: dict[str, JsonValue] = {"offset": piece.offset, "hex": _hex(piece.raw), "valid": isinstance(piece, Frame)}
    if line.at_s is not None:
        place = {"t_s": round(line.at_s, 6), **place}
    if isinstance(piece, Noise):
        direction: dict[str, JsonValue] = {} if line.way is None else {"direction": _DIRECTIONS[line.way].value}
        return place | direction | {"reason": piece.detail}
    return place | {"direction": piece.direction.value} | meaning(piece, line.asked)


def _json_text(line: DecodedLine) -> str:
    return console.as_json(as_json(line))


def _text_for_people(line: DecodedLine) -> str:
    piece = line.piece
    direction = piece.direction if isinstance(piece, Frame) else _DIRECTIONS[line.way] if line.way else None
    sender = "-" if direction is None else "host" if direction is Direction.HOST_TO_MODULE else "module"
    shown = _hex(piece.raw[:SHOWN_BYTES])
    words = sentence(piece, line.asked)
    if len(piece.raw) > SHOWN_BYTES:
        words = f"… {len(piece.raw)} B: {words}"
    place = f"{piece.offset:6}" if line.at_s is None else f"{line.at_s:11.6f}"
    return f"{place}  {sender:6}  {shown:{3 * SHOWN_BYTES - 1}}  {words}"


def _bytes_of_arguments(words: list[str]) -> Iterator[bytes]:
    """All words at once, so that an invalid one is refused before anything is printed."""
    text = HexText()
    data = text.feed(" ".join(words))
    text.finish()
    yield data


def _bytes_of_text(lines: Iterable[str]) -> Iterator[bytes]:
    """Line by line; a long line in pieces."""
    text = HexText()
    for characters in lines:
        yield text.feed(characters)
    text.finish()


def _names_file(word: str) -> bool:
    """Also one that is not there, a folder, or a pipe."""
    path = Path(word)
    return bool(path.suffix) or path.name != word or path.exists()


def _is_hex(word: str) -> bool:
    text = HexText()
    try:
        text.feed(word)
        text.finish()
    except NotHex:
        return False
    return True


def _hex(raw: bytes) -> str:
    return raw.hex(" ").upper()
