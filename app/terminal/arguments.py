"""What the parsers of several commands share: the parser itself, types of arguments, and usual options.

Help and errors of usage are English; results and errors of the module and the line are translated.
"""

import argparse
import math
import re
import sys
from contextlib import suppress
from datetime import date
from pathlib import Path
from typing import Any, Final, NoReturn, Protocol

from app.engine.target import host_and_port
from app.terminal.console import Refused, did_you_mean
from app.text.messages import UserMessage

AUTO: Final = "auto"
# `protocol.catalogue.BAUD_RATES`, written out so that the help needs no catalogue; a test holds them equal.
RATES: Final = (115200, 57600, 38400, 19200, 9600, 4800)
USUAL_RATE: Final = 115200
MAX_NAME_LENGTH: Final = 200
STANDARD_OUTPUT: Final = Path("-")
_OPTION = re.compile(r"--[a-z][a-z-]*")
_UNKNOWN_OPTION = re.compile(r"unrecognized arguments: .*?(--?[^\s=]+)")
_PORT_HELP = "serial port, socket:// or rfc2217:// address, or sim://; default: DPS_S_PORT, or the only adapter"


class Arguments(Protocol):
    """A parser, or a group of arguments in one."""

    def add_argument(self, *names: str, **options: Any) -> argparse.Action: ...


class Parser(argparse.ArgumentParser):
    """Raises `Refused` where argparse would print it and exit, so that --json can say it as an object."""

    def error(self, message: str) -> NoReturn:
        unknown = _UNKNOWN_OPTION.search(message)
        if unknown is not None:
            message += did_you_mean(unknown[1], _OPTION.findall(self.format_help()))
        raise Refused(UserMessage(f"{self.format_usage()}{self.prog}: error: {message}"), what=message)


# Types


def expected(what: str) -> argparse.ArgumentTypeError:
    """The error for argparse: which form of argument was expected."""
    return argparse.ArgumentTypeError(f"expected {what}")


def any_name(text: str) -> str:
    if len(text) > MAX_NAME_LENGTH:
        raise expected(f"≤ {MAX_NAME_LENGTH} characters")
    return text


def module_name(text: str) -> str:
    """An empty one is refused, as it would name none. "-" is a line of standard input, as a scanner types it."""
    if text == "-":
        try:
            text = sys.stdin.readline(MAX_NAME_LENGTH + 2).strip()
        except (OSError, ValueError):  # it is closed, or no text
            text = ""
    if not text.strip() or len(text) > MAX_NAME_LENGTH:
        raise expected(f"NAME (≤ {MAX_NAME_LENGTH} characters)")
    return text


def port_name(text: str) -> str:
    if not text.strip():
        raise expected("a port")
    return text


def baud_rate(text: str) -> int | None:
    """The rate; None for "auto"."""
    if text.lower() == AUTO:
        return None
    if text.isdecimal() and int(text) in RATES:
        return int(text)
    raise expected(", ".join(map(str, (*RATES, AUTO))))


def seconds(text: str) -> float:
    """A time above 0."""
    with suppress(ValueError):
        value = float(text)
        if 0 < value < math.inf:
            return value
    raise expected("seconds, more than 0")


def tcp_address(text: str) -> tuple[str, int]:
    try:
        return host_and_port(text)
    except ValueError as error:
        raise expected("HOST:PORT") from error


def day(text: str) -> date:
    with suppress(ValueError):
        return date.fromisoformat(text)
    raise expected("YYYY-MM-DD")


# Usual options


def completed_as(action: argparse.Action, kind: str) -> None:
    """What the completion scripts offer for its value: "file", or a function of `app.cli.completion`."""
    functions = {"bash": "_shtab_compgen_files", "zsh": "_files"} if kind == "file" else {"bash": kind, "zsh": kind}
    action.complete = functions  # type: ignore[attr-defined]  # an attribute that shtab asks for


def add_file(parser: Arguments, name: str, **options: Any) -> None:
    """An argument that names a file or a folder."""
    completed_as(parser.add_argument(name, **options), "file")


def add_port(parser: argparse.ArgumentParser) -> None:
    """--port, --baud and --timeout."""
    port = parser.add_argument("-p", "--port", type=port_name, metavar="P", action="append", help=_PORT_HELP)
    completed_as(port, "file")
    rates = f"baud rate: {', '.join(map(str, RATES))} or {AUTO} (default: {USUAL_RATE})"
    rate = parser.add_argument("-b", "--baud", type=baud_rate, default=USUAL_RATE, metavar="N", help=rates)
    completed_as(rate, "_dps_s_rates")
    text = "end with exit code 3 if it is not done after S seconds; lock has its own limit"
    parser.add_argument("--timeout", type=seconds, metavar="S", help=text)


def add_json(parser: Arguments) -> None:
    parser.add_argument("--json", action="store_true", help="print JSON; see dps-s schema")


def add_yes(parser: Arguments) -> None:
    parser.add_argument("--yes", action="store_true", help="do it; without it the command only says what it would do")


def add_seconds(parser: Arguments) -> None:
    parser.add_argument("--seconds", type=seconds, metavar="S", help="end after S seconds")


def add_module(parser: Arguments, text: str) -> None:
    parser.add_argument("--module", type=module_name, metavar="NAME", help=text)


def add_same_module(parser: Arguments, text: str = "it is the module of that name, although it differs") -> None:
    parser.add_argument("--same-module", action="store_true", help=text)


def add_reviewed(parser: Arguments) -> None:
    text = "the trigger records were judged; a module that never answers their query is new"
    parser.add_argument("--records-reviewed", action="store_true", help=text)


def add_verbosity(parser: Arguments) -> None:
    # Without a default: that of a sub-command's parser would replace an option given before the command.
    for names, action, text in (
        (("-v", "--verbose"), "count", "show requests on standard error; -vv: every frame"),
        (("--quiet",), "store_true", "print only errors and warnings"),
    ):
        parser.add_argument(*names, action=action, default=argparse.SUPPRESS, help=text)
