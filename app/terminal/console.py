"""What all commands share: exit codes, and printing of text and JSON.

The result goes to standard output, messages go to standard error. With --json standard output is JSON and nothing
else: English, UTF-8, whatever the system's language.
"""

import argparse
import errno
import os
import sys
import unicodedata
from collections.abc import Iterable, Sequence
from enum import Enum
from pathlib import Path
from typing import NoReturn

from app.terminal.interruption import discard, writing
from app.text.i18n import tr
from app.text.messages import (
    NEWLINE,
    ErrorCode,
    UserError,
    UserMessage,
    error_text,
    in_brackets,
    message,
    visible,
    visible_json,
)
from protocol.translatable import marked

SUCCESS = 0
ANSWER_NO = 1  # done, and the answer is no
USAGE_ERROR = 2
NO_LINK = 3  # no such port, busy, no permission, no answer
PARTIAL = 4


class Refused(UserError):
    """The command ends with this message, without a result."""

    def __init__(
        self, text: str | UserMessage, code: ErrorCode = ErrorCode.USAGE, *, what: str = "", hint: str = ""
    ) -> None:
        super().__init__(text)
        self.code = code
        self.what = what
        self.hint = hint


class OutputLost(Exception):
    """Standard output takes nothing more; the text says why, and is empty where its reader has ended."""


def refuse_without(option: str) -> NoReturn:
    """Raises `Refused`, which says what option is missing."""
    raise Refused(message(marked("Nothing was done. Add {option} to do it."), option=option))


def refuse_existing(path: Path, *, is_forced: bool, options: str = "--force") -> None:
    """Raises `Refused` where the file is there, and nobody said what becomes of it."""
    if not is_forced and os.path.lexists(path):
        raise Refused(message(marked("{file} exists: use {options}."), file=path, options=options))


def did_you_mean(word: str, offered: Iterable[str]) -> str:
    """The most similar of `offered` in brackets, to be appended; "" if none is similar."""
    from difflib import get_close_matches

    similar = get_close_matches(word, list(offered), n=1)
    return in_brackets(tr("did you mean {name}?", name=similar[0])) if similar else ""


class _Shown:
    """What this process has been told to print, and has printed."""

    def __init__(self) -> None:
        self.verbosity = 0  # -1 with --quiet, else how often -v was given
        self.has_result = False
        self.said: set[str] = set()  # by `notify_once`


_shown = _Shown()


def start(args: argparse.Namespace) -> None:
    """Called before a command runs."""
    _shown.verbosity = -1 if getattr(args, "quiet", False) else getattr(args, "verbose", 0)
    _shown.has_result = False
    _shown.said.clear()


def verbosity() -> int:
    return _shown.verbosity


def has_result() -> bool:
    """Whether anything was written to standard output."""
    return _shown.has_result


# Messages on standard error


def note(sentence: str) -> None:
    """Like `notify`, for what is neither an error nor a warning: silent with --quiet."""
    if _shown.verbosity >= 0:
        notify(sentence)


def note_wait(sentence: str) -> None:
    """Like `note`, for a person at a terminal who waits for the result."""
    if sys.stderr.isatty():
        note(sentence)


def notify(sentence: str) -> None:
    """Print a line on standard error; an error of writing it is ignored."""
    try:
        with writing():
            print(visible(sentence, keep=NEWLINE), file=sys.stderr, flush=True)
    except (OSError, ValueError):
        discard(sys.stderr)  # else Python fails to write the rest when it ends, with exit code 120


def notify_once(sentence: str) -> None:
    """Like `notify`, once in a command."""
    if sentence not in _shown.said:
        _shown.said.add(sentence)
        notify(sentence)


# The result on standard output


def write(text: str) -> None:
    """Write `text` to standard output unchanged, and flush. Raises `OutputLost`. Text from outside, which may contain
    control characters, goes through `write_lines`."""
    _shown.has_result = _shown.has_result or bool(text)
    try:
        with writing():
            sys.stdout.write(text)
            sys.stdout.flush()
    except OSError as error:
        discard(sys.stdout)
        # Windows reports a reader that has ended as an invalid argument.
        has_no_reader = error.errno in (errno.EPIPE, errno.EINVAL)
        raise OutputLost("" if has_no_reader else error_text(error)) from error
    except KeyboardInterrupt:
        discard(sys.stdout)  # nobody reads it, and Python would wait for that when it ends
        raise


class Colour(Enum):
    """The value is the ANSI code."""

    GOOD = 32
    CAUTION = 33
    BAD = 31


Line = str | tuple[str, Colour | None]
"""A line, with a colour for terminals."""


def write_lines(lines: Iterable[Line]) -> None:
    """Print lines for people, coloured on a terminal unless NO_COLOR is set."""
    has_colours = sys.stdout.isatty() and not os.environ.get("NO_COLOR")
    text = ""
    for line in lines:
        words, colour = (line, None) if isinstance(line, str) else line
        shown = visible(words)
        text += f"\x1b[{colour.value}m{shown}\x1b[0m\n" if has_colours and colour is not None else f"{shown}\n"
    write(text)


def emit(args: argparse.Namespace, answer: object, page: Iterable[Line]) -> None:
    """Print the answer, a structure, as one JSON object where --json was given, else the page: lines for people."""
    write_lines([as_json(answer)] if args.json else page)


def as_json(value: object) -> str:
    """One line. Raises `ValueError` for a number that JSON has not, such as NaN."""
    import json

    import msgspec

    return visible_json(json.dumps(msgspec.to_builtins(value), ensure_ascii=False, allow_nan=False))


def write_failure(code: ErrorCode, text: str, hint: str = "") -> None:
    """Print the error object: why a command that was called with --json has no result."""
    from app.terminal.results import ErrorJson, FailureJson

    write_lines([as_json(ErrorJson(error=FailureJson(code=code, message=text, hint=hint)))])


# Columns, where a Chinese character takes two


def display_width(text: str) -> int:
    """Number of columns that `text` takes on a terminal."""
    width = 0
    for character in text:
        if not unicodedata.combining(character):
            width += 2 if unicodedata.east_asian_width(character) in "WF" else 1
    return width


def columns(rows: Sequence[tuple[str, ...]], *, indent: int = 0) -> list[str]:
    """Left-aligned columns, two spaces apart. The last cell of a row does not widen its column."""
    widths: dict[int, int] = {}
    for row in rows:
        for number, cell in enumerate(row[:-1]):
            widths[number] = max(widths.get(number, 0), display_width(cell))
    lines: list[str] = []
    for row in rows:
        cells = [cell + " " * (widths.get(number, 0) - display_width(cell)) for number, cell in enumerate(row)]
        lines.append((" " * indent + "  ".join(cells)).rstrip())
    return lines
