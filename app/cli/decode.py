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
from collections.abc import Iterable, Iterator
from pathlib import Path

from app.captures.entries import Way
from app.captures.explain import meaning, sentence
from app.captures.explained import Explained, Explainer, HexExplainer
from app.captures.text import NotHex, TextReader, hex_bytes, lines_in
from app.terminal import console
from app.text.i18n import tr
from app.text.sentences import error_text
from app.text.user_error import UserError
from app.trigger_records.fields import JsonValue
from protocol.catalogue import BY_NAME, Command
from protocol.frame import Direction, Frame, Noise

EXAMPLE = "41 75 32"
SHOWN_BYTES = 16
"""Bytes that a line for people shows: the length of the longest frame."""
ROWS_AT_ONCE = 500
"""Of a file; standard input and pipes are printed line by line."""
_DIRECTIONS = {Way.OUT: Direction.HOST_TO_MODULE, Way.IN: Direction.MODULE_TO_HOST}


def run(args: argparse.Namespace) -> int:
    words: list[str] = args.hex
    is_file = bool(words) and not _is_hex(words[0]) and _names_file(words[0])
    if not words or (is_file and len(words) > 1):
        raise console.Refused(tr("expected {expected}", expected=f"{EXAMPLE}, FILE, -"))
    asked = BY_NAME[args.asked] if args.asked else None
    printer = _Printer(is_json=args.json)
    try:
        if words == ["-"]:
            _decode_text(lines_in(sys.stdin), asked, printer)
        elif is_file:
            path = Path(words[0])
            if path.suffix.lower() == ".mcap":
                _decode_session(path, asked, printer)
            else:
                with path.open(encoding="utf-8-sig") as file:
                    _decode_text(lines_in(file), asked, printer, at_once=ROWS_AT_ONCE if path.is_file() else 1)
        else:
            explainer = HexExplainer(asked)
            printer.print([*explainer.feed(hex_bytes(" ".join(words))), *explainer.end()], is_timed=False)
    except NotHex as error:
        raise console.Refused(tr("{word}: neither hex nor a file", word=error.word)) from error
    except UnicodeDecodeError as error:
        raise console.Refused(tr("{word}: neither hex nor a file", word=words[0])) from error
    except BrokenPipeError:
        raise
    except OSError as error:
        raise console.Refused(tr("{file} cannot be read: {why}.", file=words[0], why=error_text(error))) from error
    return console.PARTIAL if printer.has_rejected else console.SUCCESS


class _Printer:
    def __init__(self, *, is_json: bool) -> None:
        self._is_json = is_json
        self.has_rejected = False

    def print(self, rows: Iterable[Explained], *, is_timed: bool) -> None:
        texts = []
        for row in rows:
            self.has_rejected |= isinstance(row.piece, Noise)
            json_row = as_json(row, is_timed=is_timed) if self._is_json else None
            texts.append(_text_for_people(row, is_timed=is_timed) if json_row is None else console.as_json(json_row))
        console.write_lines(texts)


def _decode_session(path: Path, asked: Command | None, printer: _Printer) -> None:
    from app.recordings.library import entry_of
    from app.recordings.recording import traffic_of

    explainer = Explainer(asked)
    try:
        _print_rows(map(explainer.feed, traffic_of(entry_of(path))), explainer, printer, at_once=ROWS_AT_ONCE)
    except UserError as error:
        raise console.Refused(tr("{file} cannot be read: {why}.", file=path, why=error.sentence)) from error


def _decode_text(lines: Iterator[str], asked: Command | None, printer: _Printer, *, at_once: int = 1) -> None:
    reader = TextReader(asked)
    _print_rows(map(reader.feed, lines), reader, printer, at_once=at_once)
    for fault in reader.faults:
        console.notify(tr("Line {number} is left out: {why}.", number=fault.line, why=tr(fault.text)))
    printer.has_rejected |= bool(reader.faults)


def _print_rows(
    steps: Iterable[list[Explained]], explainer: Explainer | TextReader, printer: _Printer, *, at_once: int
) -> None:
    waiting: list[Explained] = []
    try:
        for rows in steps:
            waiting += rows
            if len(waiting) >= at_once:
                printer.print(waiting, is_timed=explainer.is_timed)
                waiting = []
        waiting += explainer.end()
    except ValueError:  # what came before text that is neither is printed
        printer.print(waiting, is_timed=explainer.is_timed)
        raise
    printer.print(waiting, is_timed=explainer.is_timed)


def as_json(row: Explained, *, is_timed: bool) -> dict[str, JsonValue]:
    """The object of one line of `decode --json`; always in English."""
    piece = row.piece
    place: dict[str, JsonValue] = {"offset": piece.offset, "hex": _hex(piece.raw), "valid": isinstance(piece, Frame)}
    if is_timed:
        place = {"t_s": round(row.at_s, 6), **place}
    if isinstance(piece, Noise):
        direction: dict[str, JsonValue] = {"direction": _DIRECTIONS[row.way].value} if is_timed else {}
        return place | direction | {"reason": piece.detail}
    return place | {"direction": piece.direction.value} | meaning(piece, row.asked)


def _text_for_people(row: Explained, *, is_timed: bool) -> str:
    piece = row.piece
    direction = piece.direction if isinstance(piece, Frame) else _DIRECTIONS[row.way] if is_timed else None
    sender = "-" if direction is None else "host" if direction is Direction.HOST_TO_MODULE else "module"
    shown = _hex(piece.raw[:SHOWN_BYTES])
    words = sentence(piece, row.asked)
    if len(piece.raw) > SHOWN_BYTES:
        words = f"… {len(piece.raw)} B: {words}"
    place = f"{row.at_s:11.6f}" if is_timed else f"{piece.offset:6}"
    return f"{place}  {sender:6}  {shown:{3 * SHOWN_BYTES - 1}}  {words}"


def _names_file(word: str) -> bool:
    """Also one that is not there, a folder, or a pipe."""
    path = Path(word)
    return bool(path.suffix) or path.name != word or path.exists()


def _is_hex(word: str) -> bool:
    try:
        hex_bytes(word)
    except NotHex:
        return False
    return True


def _hex(raw: bytes) -> str:
    return raw.hex(" ").upper()
