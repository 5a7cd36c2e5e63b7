"""What all commands share: exit codes, printing of text and JSON, progress.

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


def did_you_mean(word: str, offered: Iterable[str]) -> str:
    """The most similar of `offered` in brackets, to be appended; "" if none is similar."""
    from difflib import get_close_matches

    similar = get_close_matches(word, list(offered), n=1)
    return in_brackets(tr("did you mean {name}?", name=similar[0])) if similar else ""


# What this process prints


class _Printed:
    verbosity = 0  # -1 with --quiet, else how often -v was given
    has_result = False  # anything was written to standard output
    progress = ""  # the line that is shown now
    progress_since: float | None = None


def set_verbosity(args: argparse.Namespace) -> None:
    _Printed.verbosity = -1 if getattr(args, "quiet", False) else getattr(args, "verbose", 0)


def verbosity() -> int:
    return _Printed.verbosity


def expect_result() -> None:
    """Nothing was written yet: called before a command runs."""
    _Printed.has_result = False


def has_result() -> bool:
    """Whether anything was written to standard output."""
    return _Printed.has_result


# Messages on standard error


def note(sentence: str) -> None:
    """Like `notify`, for what is neither an error nor a warning: silent with --quiet."""
    if _Printed.verbosity >= 0:
        notify(sentence)


def notify(sentence: str) -> None:
    """Print a line on standard error; an error of writing it is ignored."""
    _wipe_progress()
    with _ignoring_errors():
        print(visible(sentence, keep=NEWLINE), file=sys.stderr, flush=True)


def show_progress(words: str) -> None:
    """Show progress in one line on standard error, which the next call replaces. Shows nothing during the first half
    second, without a terminal, and in other threads than the main one."""
    is_main = threading.current_thread() is threading.main_thread()
    if not is_main or _Printed.verbosity < 0 or sys.stderr is None or not sys.stderr.isatty():
        return
    now = time.monotonic()
    if _Printed.progress_since is None:
        _Printed.progress_since = now
    line = fitted(visible(words))
    if now - _Printed.progress_since >= PROGRESS_AFTER_S and line != _Printed.progress:
        _Printed.progress = line
        with _ignoring_errors():
            print(f"\r{line}\x1b[K", end="", file=sys.stderr, flush=True)


def clear_progress() -> None:
    """Remove the line of `show_progress`."""
    if threading.current_thread() is threading.main_thread():
        _Printed.progress_since = None
        _wipe_progress()


def _wipe_progress() -> None:
    if _Printed.progress:
        _Printed.progress = ""
        with _ignoring_errors():
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)


# The result on standard output


def write(text: str) -> None:
    """Write `text` to standard output unchanged, and flush. Raises `BrokenPipeError` or `OutputLost`. Text from
    outside, which may contain control characters, goes through `write_lines`."""
    _wipe_progress()
    _Printed.has_result = _Printed.has_result or bool(text)
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
    has_colours = sys.stdout.isatty() and not os.environ.get("NO_COLOR")
    text = ""
    for line in lines:
        shown = visible(line)
        colour = getattr(line, "colour", None)
        text += f"\x1b[{colour.value}m{shown}\x1b[0m\n" if has_colours and colour is not None else f"{shown}\n"
    write(text)


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


# Layout: colours, and columns, where a Chinese character takes two


class Colour(Enum):
    """The value is the ANSI code."""

    GOOD = 32
    CAUTION = 33
    BAD = 31


class ColouredLine(str):
    """A line that `write_lines` prints in its colour."""

    __slots__ = ("colour",)
    colour: Colour


def coloured(line: str, colour: Colour | None) -> str:
    if colour is None:
        return line
    shown = ColouredLine(line)
    shown.colour = colour
    return shown


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
    lines: list[str] = []
    for row in rows:
        cells = [padded(cell, widths.get(number, 0)) for number, cell in enumerate(row)]
        lines.append((" " * indent + "  ".join(cells)).rstrip())
    return lines
