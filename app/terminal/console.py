"""Shared by all sub-commands: exit codes, port arguments, printing of text and JSON.

The result goes to standard output, messages go to standard error. With --json standard output is JSON and nothing
else: English, UTF-8, whatever the system's language.
"""

import argparse
import errno
import os
import shutil
import sys
import threading
import time
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from enum import Enum
from functools import partial
from typing import NoReturn, TextIO

from app.text.i18n import tr
from app.text.messages import UserMessage, message
from app.text.sentences import error_text, in_brackets
from app.text.user_error import ErrorCode, UserError
from app.text.visible_text import NEWLINE, visible, visible_json
from protocol.translatable import marked

SUCCESS = 0
ANSWER_NO = 1
"""Done, and the answer is no. Also the exit code of an unexpected error."""
USAGE_ERROR = 2
NO_LINK = 3
"""No such port, busy, no permission, no answer."""
PARTIAL = 4
"""Done in part."""

PROGRESS_AFTER_S = 0.5
"""Shorter work shows no progress."""


def did_you_mean(word: str, offered: Iterable[str]) -> str:
    """The most similar of `offered` in brackets, to be appended; "" if none is similar."""
    from difflib import get_close_matches

    similar = get_close_matches(word, list(offered), n=1)
    return in_brackets(tr("did you mean {name}?", name=similar[0])) if similar else ""


class Refused(UserError):
    """The command ends with this message, without a result."""

    def __init__(self, text: str | UserMessage, code: ErrorCode = ErrorCode.USAGE) -> None:
        super().__init__(text)
        self.code = code


class OutputLost(Exception):
    """Standard output cannot be written, such as on a full disk."""


def refuse_without(option: str) -> NoReturn:
    """Raises `Refused`, which says what option is missing."""
    raise Refused(message(marked("Nothing was done. Add {option} to do it."), option=option))


# Printing


class _Verbosity:
    level = 0
    """-1 with --quiet, else how often -v was given."""


def set_verbosity(args: argparse.Namespace) -> None:
    _Verbosity.level = -1 if getattr(args, "quiet", False) else getattr(args, "verbose", 0)


def verbosity() -> int:
    return _Verbosity.level


def note(sentence: str) -> None:
    """Like `notify`, for what is neither an error nor a warning: silent with --quiet."""
    if _Verbosity.level >= 0:
        notify(sentence)


def notify(sentence: str) -> None:
    """Print a line on standard error; an error of writing it is ignored."""
    _clear_progress_line()
    with _ignoring_errors():
        print(visible(sentence, keep=NEWLINE), file=sys.stderr, flush=True)


class _ProgressLine:
    began_at: float | None = None
    shown = ""


def show_progress(words: str) -> None:
    """Show progress in one line on standard error, which the next call replaces. Shows nothing during the first half
    second, without a terminal, and in other threads than the main one."""
    if threading.current_thread() is not threading.main_thread():
        return
    if _Verbosity.level < 0 or sys.stderr is None or not sys.stderr.isatty():
        return
    now = time.monotonic()
    if _ProgressLine.began_at is None:
        _ProgressLine.began_at = now
    line = fitted(visible(words))
    if now - _ProgressLine.began_at >= PROGRESS_AFTER_S and line != _ProgressLine.shown:
        _ProgressLine.shown = line
        with _ignoring_errors():
            print(f"\r{line}\x1b[K", end="", file=sys.stderr, flush=True)


def clear_progress() -> None:
    """Remove the line of `show_progress`."""
    if threading.current_thread() is not threading.main_thread():
        return
    _ProgressLine.began_at = None
    _clear_progress_line()


def _clear_progress_line() -> None:
    if _ProgressLine.shown:
        _ProgressLine.shown = ""
        with _ignoring_errors():
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)


class _Result:
    is_begun = False
    """Whether anything was written to standard output."""


def expect_result() -> None:
    """Nothing was written yet: called before a command runs."""
    _Result.is_begun = False


def has_result() -> bool:
    return _Result.is_begun


def write(text: str) -> None:
    """Write `text` to standard output unchanged, and flush. Raises `BrokenPipeError` or `OutputLost`. Text from
    outside, which may contain control characters, goes through `write_lines`."""
    _clear_progress_line()
    _Result.is_begun = _Result.is_begun or bool(text)
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError as error:
        # Windows reports a reader that has ended as an invalid argument.
        if isinstance(error, BrokenPipeError) or (sys.platform == "win32" and error.errno == errno.EINVAL):
            raise BrokenPipeError from error
        raise OutputLost(error_text(error)) from error


def write_lines(lines: Iterable[str]) -> None:
    """Lines of `coloured` are coloured on a terminal, unless NO_COLOR is set."""
    show = partial(shown_line, has_colours=has_colours())
    write("".join(f"{line}\n" for line in map(show, lines)))


def emit(args: argparse.Namespace, answer: object, page: Iterable[str]) -> None:
    """Print the answer, a structure of `app.cli.results`, as one JSON object where --json was given, else the page:
    lines for people."""
    write_lines([as_json(answer)] if args.json else page)


def as_json(value: object) -> str:
    """One line. Raises `ValueError` for a number that JSON has not, such as NaN."""
    import json

    import msgspec

    return visible_json(json.dumps(msgspec.to_builtins(value), ensure_ascii=False, allow_nan=False))


def discard_output() -> None:
    """Discard what is still buffered for standard output, which has no reader or no space left."""
    _discard(sys.stdout)


def _discard(stream: TextIO | None) -> None:
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())  # type: ignore[union-attr]
        os.close(nowhere)
    except (OSError, ValueError, AttributeError):
        return  # it is no file


@contextmanager
def _ignoring_errors() -> Iterator[None]:
    try:
        yield
    except (OSError, ValueError, AttributeError):
        _discard(sys.stderr)  # else Python fails to write the rest when it ends, with exit code 120


# Colours


class Colour(Enum):
    """The value is the ANSI code. `LARGE`: letters of double size, for somebody at arm's length."""

    LARGE = 1
    GOOD = 32
    CAUTION = 33
    BAD = 31


class ColouredLine(str):
    """A line that `console.write_lines` prints in its colour."""

    __slots__ = ("colour",)
    colour: Colour


def coloured(line: str, colour: Colour | None) -> str:
    if colour is None:
        return line
    coloured_line = ColouredLine(line)
    coloured_line.colour = colour
    return coloured_line


def has_colours() -> bool:
    """Whether standard output takes colours; not where the environment variable NO_COLOR is set."""
    if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb" or not sys.stdout.isatty():
        return False
    return sys.platform != "win32" or "WT_SESSION" in os.environ  # the older console shows the codes


def shown_line(line: str, *, has_colours: bool) -> str:
    """The line without control characters other than those of its colour."""
    text = visible(line, keep=NEWLINE)
    if not has_colours or not isinstance(line, ColouredLine):
        return text
    if line.colour is Colour.LARGE:
        text = f"\x1b#3{text}\n\x1b#4{text}"  # upper half, lower half; twice where there are none
    return f"\x1b[{line.colour.value}m{text}\x1b[0m"


# Layout: columns, where a Chinese character takes two


def display_width(text: str) -> int:
    """Number of columns that `text` takes on a terminal."""
    return len(text) if text.isascii() else sum(_columns(character) for character in text)


def _columns(character: str) -> int:
    if unicodedata.combining(character):
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1


def padded(text: str, columns: int) -> str:
    return text + " " * (columns - display_width(text))


def fitted(text: str) -> str:
    """`text`, cut to one line of the terminal."""
    room = shutil.get_terminal_size().columns - 1
    kept = ""
    for character in text:
        room -= _columns(character)
        if room < 0:
            break
        kept += character
    return kept


def columns(rows: Sequence[tuple[str, ...]], *, indent: int = 0) -> list[str]:
    """Left-aligned columns, two spaces apart. The last cell of a row does not widen its column."""
    widths: dict[int, int] = {}
    for row in rows:
        for number, cell in enumerate(row[:-1]):
            widths[number] = max(widths.get(number, 0), display_width(cell))
    return [
        " " * indent + "  ".join(padded(cell, widths.get(number, 0)) for number, cell in enumerate(row)).rstrip()
        for row in rows
    ]
