"""Arguments of the commands as data, and the parsers made of them."""

import argparse
import math
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final, NoReturn

from app.fleet.batch_names import EXAMPLE, counted_names
from app.terminal.console import did_you_mean, flush_messages
from app.text.i18n import CHINESE, language, tr
from app.text.messages import UserMessage
from app.text.user_error import UserError
from app.text.visible_text import NEWLINE, visible
from protocol.translatable import marked

if TYPE_CHECKING:
    from datetime import date

    from _typeshed import SupportsWrite

AUTO: Final = "auto"
RATES: Final = (115200, 57600, 38400, 19200, 9600, 4800)
"""`protocol.catalogue.BAUD_RATES`, written out so that the help needs no catalogue; a test holds them equal."""
USUAL_RATE: Final = 115200
MAX_NAME_LENGTH: Final = 200
_HEADING = re.compile(r"^(\S.*):$", re.MULTILINE)


Argument = Callable[[argparse._ActionsContainer], None]
"""Adds one argument."""
Describe = Callable[["Parser"], None]
"""Adds arguments or a description: an `Argument`, `one_of`, or a function for what is not loaded before."""


def option(*names: str, text: str = "", **options: Any) -> Argument:
    """As `add_argument` of argparse takes it; `text` is its help: marked English, or the same in all languages."""

    def add(parser: argparse._ActionsContainer) -> None:
        parser.add_argument(*names, help=tr(text) or None, **options)

    return add


def flag(name: str, text: str = "") -> Argument:
    return option(name, text=text, action="store_true")


def one_of(*arguments: Argument, is_required: bool = False) -> Describe:
    """At most one of these may be given."""

    def add(parser: Parser) -> None:
        group = parser.add_mutually_exclusive_group(required=is_required)
        for argument in arguments:
            argument(group)

    return add


class Parser(argparse.ArgumentParser):
    """Takes options and other words in any order. Its messages, which repeat what was typed, cannot contain control
    characters."""

    _is_intermixing = False

    def parse_words(self, words: Sequence[str]) -> argparse.Namespace:
        """Exits like `parse_args`."""
        if any(isinstance(action, argparse._SubParsersAction) for action in self._actions):
            return self.parse_args(words)
        usage, self.usage = self.usage, self.format_usage().removeprefix(tr("usage: ")).strip().replace("%", "%%")
        self._is_intermixing = True
        try:
            namespace, unknown = self.parse_known_intermixed_args(words)
        finally:
            self._is_intermixing, self.usage = False, usage
        self._refuse(unknown)
        return namespace

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Refuses unknown words itself, so that the usage shown is that of the sub-command."""
        words, unknown = super().parse_known_args(args, namespace)
        if not self._is_intermixing:
            self._refuse(unknown)
        return words, unknown

    def _refuse(self, unknown: Sequence[str]) -> None:
        if unknown:
            word = next((word for word in unknown if word.startswith("-")), "")
            self.error(tr("unrecognized arguments: %s") % " ".join(unknown)
                       + did_you_mean(word.partition("=")[0], self._option_string_actions))  # fmt: skip

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

    def error(self, message: str) -> NoReturn:
        """Raises `WrongUsage`; a command that was given --json says it as an object, too."""
        raise WrongUsage(self.format_usage(), self.prog, message)

    def _print_message(self, message: str, file: "SupportsWrite[str] | None" = None) -> None:
        # Older releases of Python 3.11 let a message that cannot be written change the exit code.
        with suppress(AttributeError, OSError):
            super()._print_message(visible(message, keep=NEWLINE) if message else message, file)
        flush_messages()


class WrongUsage(UserError):
    """Words that the parser does not take. `what` is the sentence without the usage."""

    def __init__(self, usage: str, program: str, words: str) -> None:
        complaint = tr("%(prog)s: error: %(message)s\n") % {"prog": program, "message": words}
        super().__init__(UserMessage((usage + complaint).rstrip()))
        self.what = words


class Once(argparse.Action):
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


# Types


def expected(what: str) -> argparse.ArgumentTypeError:
    """The error for argparse: which form of argument was expected."""
    return argparse.ArgumentTypeError(tr("expected {expected}", expected=what))


def any_name(text: str) -> str:
    if len(text) > MAX_NAME_LENGTH:
        raise expected(f"≤ {MAX_NAME_LENGTH}")
    return text


def module_name(text: str) -> str:
    """An empty one is refused, as it would name none. "-" is a line of standard input, as a scanner types it."""
    if text == "-":
        try:
            text = sys.stdin.readline(MAX_NAME_LENGTH + 2).strip()
        except (AttributeError, OSError, ValueError):  # it is closed, or no text
            text = ""
    if not text.strip() or len(text) > MAX_NAME_LENGTH:
        raise expected(f"NAME (≤ {MAX_NAME_LENGTH})")
    return text


def batch_names(text: str) -> tuple[str, ...]:
    names = counted_names(text)
    if names is None:
        raise expected(EXAMPLE)
    return names


def port_name(text: str) -> str:
    if not text.strip():
        raise expected("P")
    return text


def baud_rate(text: str) -> int | None:
    """The rate; None for "auto"."""
    if text.lower() == AUTO:
        return None
    if text.isdecimal() and int(text) in RATES:
        return int(text)
    raise expected("|".join(map(str, (*RATES, AUTO))))


def seconds(text: str) -> float:
    """A time above 0."""
    with suppress(ValueError):
        if 0 < (value := float(text)) < math.inf:
            return value
    raise expected("S > 0")


def day(text: str) -> "date":
    from datetime import date

    with suppress(ValueError):
        return date.fromisoformat(text)
    raise expected("YYYY-MM-DD")


def whole_days(text: str) -> int:
    if text.isdecimal() and 0 < int(text[:9]) <= 100_000:
        return int(text)
    raise expected("N > 0")


# What several commands take


def rate_of(kinds: Iterable[object], **options: Any) -> Describe:
    """The option of the baud rate, which is one of these."""

    def add(parser: Parser) -> None:
        rates = "|".join(map(str, kinds)) + f" [{USUAL_RATE}]"
        parser.add_argument("-b", "--baud", default=USUAL_RATE, metavar="N",
                            help=tr("baud rate: {rates}", rates=rates), **options)  # fmt: skip

    return add


def _port(**options: object) -> Argument:
    text = marked("port, socket:// or sim://; default: DPS_S_PORT or the only adapter")
    return option("-p", "--port", text=text, type=port_name, metavar="P", **options)


RATE = rate_of((*RATES, AUTO), type=baud_rate)
PORT: Final = (_port(action=Once), RATE)
PORTS: Final = (_port(action="append"), RATE)
JSON = flag("--json", "JSON")
YES = flag("--yes", marked("carry it out (otherwise only shown)"))
SECONDS = option("--seconds", text=marked("end after S seconds"), type=seconds, metavar="S")
SAME_MODULE = flag("--same-module", marked("accept despite another boot count"))
VERBOSITY: Final[tuple[Describe, ...]] = (
    # Without a default: that of a sub-command's parser would replace an option given before the command.
    option("-v", "--verbose", text=marked("show requests; -vv: every frame"), action="count",
           default=argparse.SUPPRESS),
    option("--quiet", text=marked("errors and warnings only"), action="store_true", default=argparse.SUPPRESS),
)  # fmt: skip


def module_of(text: str) -> Argument:
    return option("--module", text=text, type=module_name, metavar="NAME")


# What argparse says by itself


# argparse passes its messages to gettext through the names `_` and `ngettext` of its module, which are replaced here by
# functions that call `tr`. Messages that are not in the table (of another Python) stay in English.
WORDS: Final = frozenset(
    (
        marked("usage: "),
        marked("positional arguments"),
        marked("options"),
        marked("show this help message and exit"),
        marked("%(prog)s: error: %(message)s\n"),
        marked("argument %(argument_name)s: %(message)s"),
        marked("the following arguments are required: %s"),
        marked("one of the arguments %s is required"),
        marked("unrecognized arguments: %s"),
        marked("expected one argument"),
        marked("expected at least one argument"),
        marked("ignored explicit argument %r"),
        marked("not allowed with argument %s"),
        marked("ambiguous option: %(option)s could match %(matches)s"),
        marked("invalid choice: %(value)r (choose from %(choices)s)"),
        marked("invalid %(type)s value: %(value)r"),
    )
)


def _translated(text: str) -> str:
    return tr(text) if text in WORDS else text


def translate_argparse() -> None:
    """Translate the messages of all parsers, into the language in use at that time."""
    setattr(argparse, "_", _translated)  # noqa: B010  mypy knows no such name
    setattr(argparse, "ngettext", lambda one, many, count: _translated(one if count == 1 else many))  # noqa: B010
