"""What the parsers of several commands share: the parser itself, types of arguments, and usual options.

Help and errors of usage are English; results and errors of the module and the line are translated.
"""

import argparse
import math
import re
from contextlib import suppress
from datetime import date
from typing import Any, Final, NoReturn, Protocol

from app.engine.target import host_and_port
from app.terminal.console import Refused, did_you_mean
from app.text.messages import UserMessage

AUTO: Final = "auto"
# `protocol.catalogue.BAUD_RATES`, written out so that the help needs no catalogue; a test holds them equal.
RATES: Final = (115200, 57600, 38400, 19200, 9600, 4800)
USUAL_RATE: Final = 115200
MAX_NAME_LENGTH: Final = 200
_OPTION = re.compile(r"--[a-z][a-z-]*")
_UNKNOWN_OPTION = re.compile(r"unrecognized arguments: .*?(--?[^\s=]+)")
_PORT_HELP = "serial port, socket:// or rfc2217:// address, or sim://; default: DPS_S_PORT, or the only adapter"
# Usual options, for `add`.
_OPTIONS: Final[dict[str, dict[str, Any]]] = {
    "--json": {"action": "store_true", "help": "print JSON; see dps-s schema"},
    "--yes": {"action": "store_true", "help": "do it; without it the command only says what it would do"},
    "--force": {"action": "store_true", "help": "replace the file"},
    "--accept-risk": {"action": "store_true", "help": "write values that take protection away"},
    "--records-reviewed": {
        "action": "store_true",
        "help": "the trigger records were judged; a module that never answers their query is new",
    },
    "--same-module": {"action": "store_true", "help": "it is the module of that name, although it differs"},
}


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
    """It may be empty."""
    if len(text) > MAX_NAME_LENGTH:
        raise expected(f"≤ {MAX_NAME_LENGTH} characters")
    return text


def name(text: str) -> str:
    """An empty one is refused, as it would name nothing."""
    if not text.strip():
        raise expected("NAME")
    return any_name(text)


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


def add(parser: Arguments, *options: str) -> None:
    """Usual options by their names."""
    for option in options:
        parser.add_argument(option, **_OPTIONS[option])


def completed_by(action: argparse.Action, *, bash: str, zsh: str) -> None:
    """Which functions offer its value in the completion scripts."""
    action.complete = {"bash": bash, "zsh": zsh}  # type: ignore[attr-defined]  # an attribute that shtab asks for


def add_file(parser: Arguments, option: str, **options: Any) -> None:
    """An argument that names a file or a folder."""
    completed_by(parser.add_argument(option, **options), bash="_shtab_compgen_files", zsh="_files")


def add_port(parser: argparse.ArgumentParser) -> None:
    """--port, --baud and --timeout."""
    port = parser.add_argument("-p", "--port", type=name, metavar="P", action="append", help=_PORT_HELP)
    completed_by(port, bash="_dps_s_ports", zsh="_dps_s_ports")
    rates = f"baud rate: {', '.join(map(str, RATES))} or {AUTO} (default: {USUAL_RATE})"
    parser.add_argument("-b", "--baud", type=baud_rate, default=USUAL_RATE, metavar="N", help=rates)
    text = "end with exit code 3 if it is not done after S seconds; lock has its own limit"
    parser.add_argument("--timeout", type=seconds, metavar="S", help=text)


def add_seconds(parser: Arguments) -> None:
    parser.add_argument("--seconds", type=seconds, metavar="S", help="end after S seconds")


def add_module(parser: Arguments, text: str) -> None:
    """--module, and --same-module for where something speaks against that name."""
    parser.add_argument("--module", type=name, metavar="NAME", help=text)
    add(parser, "--same-module")


def add_verbosity(parser: Arguments) -> None:
    # Without a default: that of a sub-command's parser would replace an option given before the command.
    for names, action, text in (
        (("-v", "--verbose"), "count", "show requests on standard error; -vv: every frame"),
        (("--quiet",), "store_true", "print only errors and warnings"),
    ):
        parser.add_argument(*names, action=action, default=argparse.SUPPRESS, help=text)
