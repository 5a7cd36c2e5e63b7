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
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any, Literal

import msgspec
from msgspec import UNSET, Struct, UnsetType

from app.captures.explain import meaning, sentence
from app.captures.traffic import Explained, Explainer, NotHex, TextReader, hex_bytes, lines_in
from app.terminal import console
from app.terminal.results import CommandName, Count, Hex, Result, Value
from app.text.i18n import tr
from app.text.messages import UserError
from protocol.catalogue import BY_NAME, COMMANDS, RECORD_PART, STATUS_PARTS
from protocol.messages import Direction, Frame, Noise
from protocol.translatable import marked


class RejectedJson(Result, kw_only=True, tag_field="kind", tag="rejected"):
    """Bytes that are no frame, and why."""

    t_s: float | UnsetType = UNSET
    offset: Count
    hex: Hex
    valid: Literal[False]
    direction: Direction | UnsetType = UNSET
    reason: str


class _FrameHeadJson(Result, kw_only=True):
    t_s: float | UnsetType = UNSET
    offset: Count
    hex: Hex
    valid: Literal[True]
    direction: Direction
    command: CommandName | None


# A frame with the values that it carries, from the catalogue, each left out where the frame has none.
_NAMES = [part.name for part in STATUS_PARTS] + list(RECORD_PART)
_NAMES += [key for command in COMMANDS for key in (command.reply_key, command.write_key) if key is not None]
_KINDS: dict[str, Any] = dict.fromkeys(_NAMES, Value)
_KINDS |= {"sources": list[str], "empty": bool, "acknowledged": bool, "may_answer": list[CommandName]}
DecodedFrameJson = msgspec.defstruct(
    "DecodedFrameJson",
    [(name, kind | UnsetType, UNSET) for name, kind in _KINDS.items()],
    bases=(_FrameHeadJson,),
    kw_only=True,
    tag_field="kind",
    tag="frame",
)
DecodeJson = DecodedFrameJson | RejectedJson


def add_arguments(parser: argparse.ArgumentParser) -> None:
    words, asked = "hex bytes, a recording or capture, or - for standard input", f"what was asked: {', '.join(BY_NAME)}"
    console.add_file(parser, "hex", metavar="HEX", help=words, nargs="*", type=str)
    parser.add_argument("--asked", metavar="NAME", choices=sorted(BY_NAME), help=asked)


def run(args: argparse.Namespace) -> int:
    words: list[str] = args.hex
    path = Path(words[0]) if words and _names_file(words[0]) else None
    if not words or (path is not None and len(words) > 1):
        raise console.Refused(tr("expected {expected}", expected="41 75 32, FILE, -"))
    asked, faults = BY_NAME.get(args.asked), list[str]()
    try:
        with ExitStack() as files:
            reader: TextReader | Explainer = TextReader(asked)
            parts: Iterable[Any] = [" ".join(words)]
            if path is not None and path.suffix.lower() == ".mcap":
                from app.recordings.session_file import SessionFile

                recorded = SessionFile(path)
                reader, parts = Explainer(asked), recorded.traffic()
            elif path is not None:
                parts = lines_in(files.enter_context(path.open(encoding="utf-8-sig")))
            elif words == ["-"]:
                parts = lines_in(sys.stdin)
            is_whole = True
            for part in parts:  # each is printed as it comes
                is_whole &= _print_rows(reader.feed(part), is_json=args.json)
            is_whole &= _print_rows(reader.end(), is_json=args.json)
    except NotHex as error:
        raise console.Refused(tr("{word}: neither hex nor a file", word=error)) from error
    except UnicodeDecodeError as error:
        raise console.unreadable(words[0], UserError(marked("unknown kind of file"))) from error
    except (OSError, UserError) as error:
        raise console.unreadable(words[0], error) from error
    if isinstance(reader, TextReader):
        text = marked("Line {number} is left out: no time, direction and bytes.")
        faults = [tr(text, number=number) for number in reader.faults]
    elif recorded.damage is not None:
        faults = [recorded.damage.translated()]
    for fault in faults:
        console.notify(fault)
    return console.SUCCESS if is_whole and not faults else console.PARTIAL


def _names_file(word: str) -> bool:
    with suppress(NotHex):
        hex_bytes(word)
        return False
    return word != "-"


def _print_rows(rows: list[Explained], *, is_json: bool) -> bool:
    # Whether every byte is part of a frame.
    console.write_lines(console.as_json(_as_json(row)) if is_json else _line(row) for row in rows)
    return all(isinstance(row.piece, Frame) for row in rows)


def _as_json(row: Explained) -> Struct:
    # Always in English.
    piece = row.piece
    usual: dict[str, Any] = {
        "t_s": UNSET if row.at_s is None else round(row.at_s, 6),
        "offset": piece.offset,
        "hex": piece.raw.hex(" ").upper(),
    }
    if isinstance(piece, Noise):
        direction = UNSET if row.at_s is None else row.direction
        return RejectedJson(**usual, valid=False, direction=direction, reason=piece.reason.value)
    return DecodedFrameJson(**usual, valid=True, direction=piece.direction, **meaning(piece, row.asked))


def _line(row: Explained) -> str:
    piece = row.piece
    direction = piece.direction if isinstance(piece, Frame) else None if row.at_s is None else row.direction
    sender = "-" if direction is None else "host" if direction is Direction.HOST_TO_MODULE else "module"
    place = f"{piece.offset:6}" if row.at_s is None else f"{row.at_s:11.6f}"
    return f"{place}  {sender:6}  {piece.raw.hex(' ').upper():47}  {sentence(piece, row.asked)}"
