"""Shared by all sub-commands: exit codes, port arguments, printing of text and JSON.

The result goes to standard output, messages go to standard error. With --json standard output is JSON and nothing
else: English, UTF-8, whatever the system's language.
"""

import argparse
import errno
import math
import os
import re
import shutil
import sys
import threading
import time
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from typing import TYPE_CHECKING, TextIO

from app.terminal.colours import has_colours, shown_line
from app.text.i18n import CHINESE, language, tr
from app.text.messages import UserMessage
from app.text.sentences import error_text, in_brackets
from app.text.user_error import UserError
from app.text.visible_text import NEWLINE, visible, visible_json

if TYPE_CHECKING:
    from _typeshed import SupportsWrite

SUCCESS = 0
ANSWER_NO = 1
"""Done, and the answer is no. Also the exit code of an unexpected error."""
USAGE_ERROR = 2
NO_LINK = 3
"""No such port, busy, no permission, no answer."""
PARTIAL = 4
"""Done in part."""

_HEADING = re.compile(r"^(\S.*):$", re.MULTILINE)
AUTO = "auto"
RATES = (115200, 57600, 38400, 19200, 9600, 4800)
"""`protocol.catalogue.BAUD_RATES`, written out so that the help needs no catalogue; a test holds them equal."""
USUAL_RATE = 115200
MAX_NAME_LENGTH = 200
PROGRESS_AFTER_S = 0.5
"""Shorter work shows no progress."""


class Parser(argparse.ArgumentParser):
    """A parser whose messages, which repeat what was typed, cannot contain control characters."""

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Refuses unknown words itself, so that the usage shown is that of the sub-command."""
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            word = next((one for one in unknown if one.startswith("-")), "")
            self.error(tr("unrecognized arguments: %s") % " ".join(unknown)
                       + did_you_mean(word.partition("=")[0], self._option_string_actions))  # fmt: skip
        return found, unknown

    def _check_value(self, action: argparse.Action, value: object) -> None:
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            error.message += did_you_mean(str(value), map(str, action.choices or ()))
            raise

    def format_help(self) -> str:
        """Headings end with a full-width colon in Chinese; argparse appends the colon itself."""
        text = super().format_help()
        return _HEADING.sub(r"\1：", text) if language() == CHINESE else text

    def _print_message(self, message: str, file: "SupportsWrite[str] | None" = None) -> None:
        # Older releases of Python 3.11 let a message that cannot be written change the exit code.
        with suppress(AttributeError, OSError):
            super()._print_message(visible(message, keep=NEWLINE) if message else message, file)
        _flush_messages()


def did_you_mean(word: str, offered: Iterable[str]) -> str:
    """The most similar of `offered` in brackets, to be appended; "" if none is similar."""
    from difflib import get_close_matches

    similar = get_close_matches(word, list(offered), n=1)
    return in_brackets(tr("did you mean {name}?", name=similar[0])) if similar else ""


class _Once(argparse.Action):
    """Refused where it is given twice: who locks two ports with one command would find only the last one locked."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: object,
        option_string: str | None = None,
    ) -> None:
        if getattr(namespace, self.dest) is not None:
            parser.error(tr("{name} is given twice.", name=option_string))
        setattr(namespace, self.dest, values)


class Refused(UserError):
    """The command ends with this message and this exit code; with any other `UserError` it is a usage error."""

    def __init__(self, text: str | UserMessage, exit_code: int = USAGE_ERROR) -> None:
        super().__init__(text)
        self.exit_code = exit_code


class OutputLost(Exception):
    """Standard output cannot be written, such as on a full disk."""


def add_port_arguments(parser: argparse.ArgumentParser, *, takes_several: bool = False) -> None:
    """With `takes_several`, `port` is a list if it was given."""
    parser.add_argument("-p", "--port", type=_port, action="append" if takes_several else _Once, metavar="P",
                        help=tr("port, socket:// or sim://; default: DPS_S_PORT or the only adapter"))  # fmt: skip
    rates = "|".join(map(str, (*RATES, AUTO))) + f" [{USUAL_RATE}]"
    parser.add_argument(
        "-b", "--baud", type=_rate, default=USUAL_RATE, metavar="N", help=tr("baud rate: {rates}", rates=rates)
    )


def add_verbosity_arguments(parser: argparse.ArgumentParser) -> None:
    """Add -v and --quiet to `parser` and to the parsers of its sub-commands."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for one in action.choices.values():
                add_verbosity_arguments(one)
    # Without a default: that of a sub-command's parser would replace an option given before the command.
    parser.add_argument("-v", "--verbose", action="count", default=argparse.SUPPRESS,
                        help=tr("show requests; -vv: every frame"))  # fmt: skip
    parser.add_argument("--quiet", action="store_true", default=argparse.SUPPRESS, help=tr("errors and warnings only"))


def add_json_argument(parser: argparse._ActionsContainer) -> None:
    parser.add_argument("--json", action="store_true", help="JSON")


def add_module_argument(parser: argparse.ArgumentParser, text: str) -> None:
    """The name of a module; an empty one is refused, as it would name none."""
    parser.add_argument("--module", type=_name, metavar="NAME", help=text)


def add_yes_argument(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--yes", action="store_true", help=tr("carry it out (otherwise only shown)"))


def add_seconds_argument(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seconds", type=seconds, metavar="S", help=tr("end after S seconds"))


def refuse_without(option: str) -> int:
    """Print which option is missing; returns the exit code."""
    notify(tr("Nothing was done. Add {option} to do it.", option=option))
    return USAGE_ERROR


def expected(what: str) -> argparse.ArgumentTypeError:
    """The error for argparse: which form of argument was expected."""
    return argparse.ArgumentTypeError(tr("expected {expected}", expected=what))


def _name(text: str) -> str:
    if not text.strip() or len(text) > MAX_NAME_LENGTH:
        raise expected(f"NAME (≤ {MAX_NAME_LENGTH})")
    return text


def _port(text: str) -> str:
    if not text.strip():
        raise expected("P")
    return text


def _rate(text: str) -> int | None:
    """The rate; None for "auto"."""
    if text.lower() == AUTO:
        return None
    if text.isdecimal() and int(text) in RATES:
        return int(text)
    raise expected("|".join(map(str, (*RATES, AUTO))))


def seconds(text: str) -> float:
    """A time above 0, for argparse."""
    with suppress(ValueError):
        if 0 < (value := float(text)) < math.inf:
            return value
    raise expected("S > 0")


# Printing


class _Verbosity:
    """How much is written to standard error."""

    level = 0
    """-1 with --quiet, else how often -v was given."""


def set_verbosity(args: argparse.Namespace) -> None:
    """Take it from the arguments that `add_verbosity_arguments` added."""
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


def _flush_messages() -> None:
    with _ignoring_errors():
        sys.stderr.flush()


class _ProgressLine:
    """State of the progress line."""

    began_at: float | None = None
    shown = ""


def show_progress(words: str) -> None:
    """Show progress in one line on standard error, which the next call replaces.

    Shows nothing during the first half second, without a terminal, and in other threads than the main one.
    """
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


def write(text: str) -> None:
    """Write `text` to standard output unchanged, and flush. Raises `BrokenPipeError` or `OutputLost`.

    Text from outside, which may contain control characters, goes through `write_lines`.
    """
    _clear_progress_line()
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError as error:
        if is_closed_pipe(error):
            raise BrokenPipeError from error
        raise OutputLost(error_text(error)) from error


def is_closed_pipe(error: OSError) -> bool:
    """The reader of standard output has ended; Windows reports that as an invalid argument."""
    return isinstance(error, BrokenPipeError) or (sys.platform == "win32" and error.errno == errno.EINVAL)


def write_lines(lines: Iterable[str]) -> None:
    """Lines of `coloured` are coloured on a terminal, unless NO_COLOR is set."""
    show = partial(shown_line, has_colours=has_colours())
    write("".join(f"{line}\n" for line in map(show, lines)))


def write_json(value: object) -> None:
    write_lines([as_json(value)])


def as_json(value: object) -> str:
    import json

    return visible_json(json.dumps(value, ensure_ascii=False))


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


# Layout: columns, where a Chinese character takes two


def display_width(text: str) -> int:
    """Number of columns that `text` takes on a terminal."""
    return sum(_columns(character) for character in text)


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
