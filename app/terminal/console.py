"""What all commands share: the parser and its usual options, exit codes, printing, and the signals that end a command.

The result goes to standard output, messages go to standard error. With --json standard output is JSON and nothing else.
Help and errors of usage are English; results and errors of the module and the line are translated.
"""

import argparse
import errno
import math
import os
import re
import signal
import sys
import threading
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from itertools import zip_longest
from pathlib import Path
from types import FrameType
from typing import Any, Final, NoReturn

from app.text.i18n import tr
from app.text.messages import (
    ErrorCode,
    UserError,
    UserMessage,
    clean,
    error_text,
    in_brackets,
    message,
    not_written,
    visible,
    visible_json,
)
from protocol.translatable import marked

SUCCESS: Final = 0
ANSWER_NO: Final = 1  # done, and the answer is no
USAGE_ERROR: Final = 2
NO_LINK: Final = 3  # no such port, busy, no permission, no answer
PARTIAL: Final = 4


class Refused(UserError):
    """The command ends with this message, without a result."""

    def __init__(
        self, text: str | UserMessage, code: ErrorCode = ErrorCode.USAGE, *, what: str = "", hint: str = ""
    ) -> None:
        super().__init__(text)
        self.code, self.what, self.hint = code, what, hint


class OutputLost(Exception):
    """Standard output takes nothing more; the text says why, and is empty where its reader has ended."""


class _Run:
    """The options of this process, and what it has printed."""

    verbosity = 0  # -1 with --quiet, else how often -v was given
    has_result = False  # something was written to standard output
    signal: int | None = None  # the first one that was noted
    is_writing = False

    def __init__(self) -> None:
        self.said: set[str] = set()  # by `notify_once`


state = _Run()


def start(args: argparse.Namespace) -> None:
    state.verbosity = -1 if getattr(args, "quiet", False) else getattr(args, "verbose", 0)
    state.has_result = False
    state.said.clear()


# Arguments

AUTO: Final = "auto"
# `protocol.catalogue.BAUD_RATES`, written out so that the help needs no catalogue; a test holds them equal.
RATES: Final = (115200, 57600, 38400, 19200, 9600, 4800)
USUAL_RATE: Final = 115200


class Parser(argparse.ArgumentParser):
    """A parser that raises `Refused` where argparse would print it and exit, so that --json can say it as an object.
    Options are typed in full: --ye is no word for an act."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(allow_abbrev=False, **settings)

    def error(self, message: str) -> NoReturn:
        unknown = re.search(r"unrecognized arguments: .*?(--?[^\s=]+)", message)
        if unknown is not None:
            message += did_you_mean(unknown[1], re.findall(r"--[a-z][a-z-]*", self.format_help()))
        message = re.sub(r"invalid \S+ value: ", "invalid value: ", message)  # argparse names the function
        raise Refused(UserMessage(f"{self.format_usage()}{self.prog}: error: {message}"), what=message)


def did_you_mean(word: str, offered: Iterable[str]) -> str:
    """The most similar of `offered` in brackets, to be appended; "" if none is similar."""
    # It is slow to load, and needed only where a word is wrong.
    from difflib import get_close_matches

    similar = get_close_matches(word, list(offered), n=1)
    return in_brackets(tr("did you mean {name}?", name=similar[0])) if similar else ""


# Kinds of arguments. Where they raise ValueError argparse says which word is no such thing.


def name(text: str) -> str:
    if not text.strip():  # it would name nothing
        raise ValueError
    return text


def baud_rate(text: str) -> int | None:
    if text.lower() == AUTO:
        return None
    if text not in map(str, RATES):
        raise argparse.ArgumentTypeError(f"expected {', '.join(map(str, (*RATES, AUTO)))}")
    return int(text)


def seconds(text: str) -> float:
    if not 0 < float(text) < math.inf:
        raise ValueError
    return float(text)


def add_file(parser: Any, *names: str, **settings: Any) -> None:
    """Add an argument that is a file or a folder, and completed as such by the shell."""
    action = parser.add_argument(*names, **{"type": Path, **settings})
    action.complete = {"bash": "_shtab_compgen_files", "zsh": "_files"}


def add_port(parser: argparse.ArgumentParser) -> None:
    text = "serial port, socket:// or rfc2217:// address, or sim://; default: DPS_S_PORT, or the only adapter"
    port: Any = parser.add_argument("-p", "--port", type=name, metavar="P", action="append", help=text)
    port.complete = {"bash": "_dps_s_ports", "zsh": "_dps_s_ports"}
    text = f"baud rate: {', '.join(map(str, RATES))} or {AUTO} (default: {USUAL_RATE})"
    parser.add_argument("-b", "--baud", type=baud_rate, default=USUAL_RATE, metavar="N", help=text)


def add_module(parser: argparse.ArgumentParser, text: str) -> None:
    """--module, and --same-module for where something speaks against that name."""
    parser.add_argument("--module", type=lambda word: clean(name(word).strip()), metavar="NAME", help=text)
    parser.add_argument("--same-module", action="store_true", help="it is the module of that name, although it differs")


def add_flags(parser: Any, *flags: str) -> None:
    """Options without a value that several commands have."""
    for flag in flags:
        parser.add_argument(flag, action="store_true", help=_FLAGS[flag])


def add_everywhere(parser: argparse.ArgumentParser) -> None:
    # Without a default: that of a sub-command's parser would replace an option given before the command.
    text = "show what is sent and received on standard error; -vv: every frame, and the log"
    parser.add_argument("-v", "--verbose", action="count", default=argparse.SUPPRESS, help=text)
    text = "print only errors and warnings"
    parser.add_argument("--quiet", action="store_true", default=argparse.SUPPRESS, help=text)


def add_command(commands: Any, function: Callable[..., int], word: str, summary: str) -> Any:
    """A command of a command, whose `args.function` does it. Its group takes --json or another form."""
    command = commands.add_parser(word, help=summary)
    command.set_defaults(function=function)
    command.form = command.add_mutually_exclusive_group()
    add_flags(command.form, "--json")
    add_everywhere(command)
    return command


_FLAGS: Final = {
    "--json": "print JSON; see dps-s schema",
    "--yes": "do it; without it the command only says what it would do",
    "--force": "replace the file",
    "--accept-risk": "write values that take protection away",
    "--records-reviewed": "the trigger records were judged; a module that never answers their query is new",
}


def require(option: str, *, is_given: bool) -> None:
    if not is_given:
        raise Refused(message(marked("Nothing was done. Add {option} to do it."), option=option))


def unreadable(file: object, error: Exception) -> Refused:
    text = message(marked("{file} cannot be read: {why}."), file=file, why=error_text(error))
    return Refused(text, ErrorCode.UNREADABLE)


def refuse_existing(path: Path, *, is_forced: bool) -> None:
    if not is_forced and os.path.lexists(path):
        raise Refused(message(marked("{file} exists: use {options}."), file=path, options="--force"))


# Signals


@contextmanager
def signals_noted() -> Iterator[None]:
    """Only note signals until the block ends; `check_signals` raises them. So none interrupts the switching off of a
    stream. Only what goes to standard output is broken off, as nobody may read the pipe. It does nothing in other
    threads."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def note(number: int, _frame: FrameType | None) -> None:
        state.signal = state.signal or number
        if state.is_writing:
            raise KeyboardInterrupt(state.signal)

    state.signal = None
    with ExitStack() as handlers:
        for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK"):
            number = getattr(signal, name, None)  # not all platforms have all of them
            if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
                handlers.callback(signal.signal, number, signal.signal(number, note))
        yield


def check_signals() -> None:
    # Raises KeyboardInterrupt with the number of the signal.
    if state.signal is not None:
        raise KeyboardInterrupt(state.signal)


# Messages on standard error


def note(sentence: str) -> None:
    """Notify of what is neither an error nor a warning: it is silent with --quiet."""
    if state.verbosity >= 0:
        notify(sentence)


def notify(sentence: str) -> None:
    # Print a line on standard error; an error of writing it is ignored.
    with suppress(OSError, ValueError):
        _print(sys.stderr, visible(sentence, keep="\n") + "\n")


def notify_once(sentence: str) -> None:
    """Notify once in a command."""
    if sentence not in state.said:
        state.said.add(sentence)
        notify(sentence)


def wrote(path: object, write_file: Callable[[], object]) -> bool:
    """Whether the file could be written; why not is printed."""
    try:
        write_file()
    except (UserError, OSError, ValueError) as error:  # ValueError: a NUL in the name
        notify(not_written(path, error))
        return False
    return True


# The result on standard output

# A line for people, with a colour for terminals: its ANSI code, 0 for none.
GOOD, BAD = 32, 31
Line = str | tuple[str, int]


def write(text: str) -> None:
    """Write `text` to standard output unchanged, and flush. Raises `OutputLost`. Text from outside, which may contain
    control characters, goes through `write_lines`."""
    state.has_result |= bool(text)
    state.is_writing = True
    try:
        _print(sys.stdout, text)
    except OSError as error:
        # Windows reports a reader that has ended as an invalid argument.
        has_no_reader = error.errno in (errno.EPIPE, errno.EINVAL)
        raise OutputLost("" if has_no_reader else error_text(error)) from error
    finally:
        state.is_writing = False


def _print(stream: Any, text: str) -> None:
    try:
        stream.write(text)
        stream.flush()
    except (OSError, ValueError, KeyboardInterrupt):
        # All that follows is led to nowhere: Python would wait for its reader, or fail to write it when it ends.
        with suppress(OSError, ValueError):  # it is no file
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)
        raise


def write_lines(lines: Iterable[Line]) -> None:
    """Print lines for people, coloured on a terminal unless NO_COLOR is set."""
    # https://no-color.org: any value but an empty one switches colours off.
    has_colours = sys.stdout.isatty() and not os.environ.get("NO_COLOR")
    text = ""
    for line in lines:
        words, colour = (line, 0) if isinstance(line, str) else line
        shown = visible(words)
        text += f"\x1b[{colour}m{shown}\x1b[0m\n" if has_colours and colour else f"{shown}\n"
    write(text)


def emit(args: argparse.Namespace, answer: object, page: Iterable[Line], code: int = SUCCESS) -> int:
    """Print the answer, a structure, as one JSON object where --json was given, else the page: lines for people. Return
    the exit code."""
    write_lines([as_json(answer)] if args.json else page)
    return code


def as_json(value: object) -> str:
    # One line. Raises `ValueError` for a number that JSON has not, such as NaN.
    # msgspec alone would write NaN as null, which here says that a value cannot be known.
    import json

    import msgspec

    return visible_json(json.dumps(msgspec.to_builtins(value), ensure_ascii=False, allow_nan=False))


def failure_of(error: Exception) -> UserError:
    # Why a command has no result, as it is printed.
    if isinstance(error, UserError) and error.code is not ErrorCode.INTERRUPTED:  # which is told with what to do next
        return error
    if isinstance(error, ImportError):
        from app.system.libraries import missing_libraries

        package = (error.name or "").partition(".")[0]
        sentence = missing_libraries()
        if isinstance(error, ModuleNotFoundError) and package not in ("", "app", "protocol", "ui"):
            sentence = tr("The Python package {package} is missing. Install the program again.", package=package)
        if sentence is not None:
            return Refused(sentence, ErrorCode.INTERNAL)
    from app.diagnosis.causes import explain
    from app.engine.transport import PortError, PortErrorKind

    why = explain(error)
    code = error.code if isinstance(error, UserError) else ErrorCode.INTERNAL
    if isinstance(error, PortError):
        code = {
            PortErrorKind.MISSING: ErrorCode.NO_PORT,
            PortErrorKind.UNUSABLE: ErrorCode.NO_PORT,
            PortErrorKind.BUSY: ErrorCode.BUSY,
            PortErrorKind.NOT_ALLOWED: ErrorCode.NO_PERMISSION,
            PortErrorKind.UNSUPPORTED: ErrorCode.USAGE,
        }.get(error.kind, ErrorCode.NO_LINK)
    return Refused(why.terminal_sentence, code, what=why.what, hint=why.next_step)


def fail(error: Exception, *, is_json: bool) -> int:
    """Say why there is no result, and print it as an object where that is wanted; returns the exit code."""
    failure = failure_of(error)
    notify(failure.sentence)
    if is_json:
        from app.terminal.results import ErrorJson, FailureJson

        told = FailureJson.of(failure, message=failure.what or failure.sentence)
        write_lines([as_json(ErrorJson(told))])
    return failure.code.exit_code


def columns(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Left-aligned columns, two spaces apart. The last cell of a row, mostly a sentence, does not widen its column: it
    would push every line over the edge of the terminal."""

    def width(text: str) -> int:
        # A Chinese character takes two columns of a terminal.
        return sum(2 if unicodedata.east_asian_width(character) in "WF" else 1 for character in text)

    widths = [max(map(width, column)) for column in zip_longest(*(row[:-1] for row in rows), fillvalue="")]
    lines: list[str] = []
    for row in rows:
        cells = [cell + " " * (widest - width(cell)) for cell, widest in zip(row[:-1], widths, strict=False)]
        lines.append("  ".join((*cells, *row[-1:])).rstrip())
    return lines
