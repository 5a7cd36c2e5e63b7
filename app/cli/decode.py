"""`dps-s decode`: explains captured bytes. Every byte belongs to exactly one line of the output, in order.

    dps-s decode 41 75 32 07 0A 00 01 44          bytes as arguments
    dps-s decode session.mcap                     a session of this program, or a file of hex text
    dps-s decode --json - < capture.txt           either of them from standard input, as it arrives

In a capture each direction is decoded by itself, so frames that crossed on the wire stay whole; `offset` counts the
bytes of that direction, and each line has its time. Exit code 0; 2 for text that is neither; 4 if some bytes were no
frame, or some of the file is missing or could not be read.
"""

import argparse
import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from msgspec import UNSET, Struct

from app.captures.explain import meaning, sentence
from app.captures.text import NotHex, TextReader, hex_bytes, lines_in
from app.captures.traffic import Explained, Explainer, Way
from app.cli.results import DecodedFrameJson, RejectedJson
from app.terminal import console
from app.terminal.arguments import add_file, add_json
from app.text.i18n import tr
from app.text.sentences import error_text
from app.text.user_error import ErrorCode, UserError
from protocol.catalogue import BY_NAME, Command
from protocol.frame import Direction, Frame, Noise

EXAMPLE = "41 75 32"
SHOWN_BYTES = 16
"""Bytes that a line for people shows: the length of the longest frame."""
ROWS_AT_ONCE = 500
"""Of a file; standard input and pipes are printed line by line."""
_DIRECTIONS = {Way.OUT: Direction.HOST_TO_MODULE, Way.IN: Direction.MODULE_TO_HOST}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_file(
        parser, "hex", nargs="*", metavar="HEX", help="hex bytes, a recording or a capture, or - for standard input"
    )
    parser.add_argument(
        "--asked",
        metavar="NAME",
        choices=sorted(BY_NAME),
        help=f"what was asked, where the host's frames are missing: {', '.join(BY_NAME)}",
    )
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    words: list[str] = args.hex
    is_file = bool(words) and _names_file(words[0])
    if not words or (is_file and len(words) > 1):
        raise console.Refused(tr("expected {expected}", expected=f"{EXAMPLE}, FILE, -"))
    asked = BY_NAME[args.asked] if args.asked else None
    path = Path(words[0])
    try:
        if is_file and path.suffix.lower() == ".mcap":
            is_whole = _decode_session(path, asked, args)
        elif is_file:
            with path.open(encoding="utf-8-sig") as file:
                at_once = ROWS_AT_ONCE if path.is_file() else 1
                is_whole = _decode_text(lines_in(file), asked, args, at_once=at_once)
        else:
            lines = lines_in(sys.stdin) if words == ["-"] else [" ".join(words)]
            is_whole = _decode_text(lines, asked, args)
    except (NotHex, UnicodeDecodeError) as error:
        if is_file and isinstance(error, UnicodeDecodeError):
            why = tr("unknown kind of file")
            text = tr("{file} cannot be read: {why}.", file=words[0], why=why)
            raise console.Refused(text, ErrorCode.UNREADABLE) from error
        word = error.word if isinstance(error, NotHex) else words[0]
        raise console.Refused(tr("{word}: neither hex nor a file", word=word)) from error
    except BrokenPipeError:
        raise
    except (OSError, UserError) as error:
        text = tr("{file} cannot be read: {why}.", file=words[0], why=error_text(error))
        raise console.Refused(text, ErrorCode.UNREADABLE) from error
    return console.SUCCESS if is_whole else console.PARTIAL


def _decode_session(path: Path, asked: Command | None, args: argparse.Namespace) -> bool:
    """Whether every byte is part of a frame, and nothing is missing."""
    from app.recordings.recording import RecordedTraffic

    explainer, traffic = Explainer(asked), RecordedTraffic(path)
    is_whole = _print_rows(map(explainer.feed, traffic), explainer, args, at_once=ROWS_AT_ONCE)
    if traffic.damage is not None:
        console.notify(traffic.damage.translated())
    return is_whole and traffic.damage is None


def _decode_text(lines: Iterable[str], asked: Command | None, args: argparse.Namespace, *, at_once: int = 1) -> bool:
    """Whether every byte is part of a frame, and every line could be read."""
    reader = TextReader(asked)
    is_whole = _print_rows(map(reader.feed, lines), reader, args, at_once=at_once)
    for fault in reader.faults:
        console.notify(tr("Line {number} is left out: {why}.", number=fault.line, why=tr(fault.text)))
    return is_whole and not reader.faults


def _print_rows(
    steps: Iterable[list[Explained]], reader: Explainer | TextReader, args: argparse.Namespace, *, at_once: int
) -> bool:
    """Print the rows of all steps; whether every byte is part of a frame."""
    waiting, is_whole = list[Explained](), True
    shown = _line_of_json if args.json else _line_for_people

    def write() -> None:
        nonlocal is_whole
        is_whole &= not any(isinstance(row.piece, Noise) for row in waiting)
        console.write_lines([shown(row) for row in waiting])
        waiting.clear()

    try:
        for rows in steps:
            waiting += rows
            if len(waiting) >= at_once:
                write()
        waiting += reader.end()
    finally:  # what came before text that is neither is printed
        write()
    return is_whole


def _line_of_json(row: Explained) -> str:
    return console.as_json(as_json(row))


def as_json(row: Explained) -> Struct:
    """The object of one line of `decode --json`; always in English."""
    piece = row.piece
    time_s = UNSET if row.at_s is None else round(row.at_s, 6)
    if isinstance(piece, Noise):
        direction = UNSET if row.at_s is None else _DIRECTIONS[row.way]
        return RejectedJson(
            t_s=time_s, offset=piece.offset, hex=_hex(piece.raw), valid=False, direction=direction, reason=piece.detail
        )
    return DecodedFrameJson(
        t_s=time_s,
        offset=piece.offset,
        hex=_hex(piece.raw),
        valid=True,
        direction=piece.direction,
        **meaning(piece, row.asked),
    )


def _line_for_people(row: Explained) -> str:
    piece = row.piece
    direction = piece.direction if isinstance(piece, Frame) else None if row.at_s is None else _DIRECTIONS[row.way]
    sender = "-" if direction is None else "host" if direction is Direction.HOST_TO_MODULE else "module"
    shown = _hex(piece.raw[:SHOWN_BYTES])
    words = sentence(piece, row.asked)
    if len(piece.raw) > SHOWN_BYTES:
        words = f"… {len(piece.raw)} B: {words}"
    place = f"{piece.offset:6}" if row.at_s is None else f"{row.at_s:11.6f}"
    return f"{place}  {sender:6}  {shown:{3 * SHOWN_BYTES - 1}}  {words}"


def _names_file(word: str) -> bool:
    """Also one that is not there, a folder, or a pipe."""
    with suppress(NotHex):
        hex_bytes(word)
        return False
    path = Path(word)
    return bool(path.suffix) or path.name != word or path.exists()


def _hex(raw: bytes) -> str:
    return raw.hex(" ").upper()
