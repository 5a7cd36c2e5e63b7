"""`dps-s set NAME=VALUE …`: change settings.

All values are checked before the first one is sent. A set goes onto the wire once; unanswered, it may have been carried
out, which is said. Exit code 1 when one of them was not acknowledged.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.commands.console import (
    DONE,
    NO_LINK,
    SAID_NO,
    USED_WRONGLY,
    Row,
    add_json_argument,
    add_port_arguments,
    as_json,
    say,
    two_columns,
    write_lines,
)
from app.i18n import tr

if TYPE_CHECKING:
    from app.procedure import Procedure
    from protocol.catalogue import Command
    from protocol.fields import Field, Value

NAMES = ("serial_output",)
"""The settings on offer, by key. One that can be read back also needs the reading back before it may stand here."""

_WORDS = {"true": True, "on": True, "yes": True, "false": False, "off": False, "no": False}


class Unfit(ValueError):
    """A word of the command line that is no setting with a value for it; the text is a sentence for people."""


@dataclass(frozen=True, slots=True)
class Wish:
    """A checked value for one setting, in the field's unit."""

    command: "Command"
    value: "Value"


@dataclass(frozen=True, slots=True)
class Result:
    """What became of one wish. `error`: English, for JSON; `words`: the same for people, in their language."""

    wanted: "Value"
    is_acknowledged: bool
    error: str | None = None
    words: str | None = None
    is_link_lost: bool = False


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = subparsers.add_parser(
        "set",
        description=tr(
            "Change settings: {names} (true or false). What cannot be read back is only ever acknowledged, never "
            "verified. Exit code 1 where the module did not acknowledge.",
            names=", ".join(NAMES),
        ),
    )
    parser.add_argument("wishes", nargs="+", metavar="NAME=VALUE", help=tr("for example serial_output=false"))
    add_port_arguments(parser)
    add_json_argument(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    from app.commands.connection import connected, link_trouble

    try:
        wishes = parse(args.wishes)
    except Unfit as error:
        say(str(error))
        return USED_WRONGLY
    results: dict[str, Result] = {}
    trouble: str | None = None
    with connected(args.port, args.baud) as conversation:
        for wish in wishes:
            try:
                results[wish.command.key] = conversation.run(_write(wish))
            except Exception as error:
                trouble = link_trouble(error)
                if trouble is None:
                    raise
                results[wish.command.key] = _lost(wish)
    write_lines([as_json(json_of(results))] if args.json else page_of(results))
    if trouble is not None:
        say(trouble)
    if any(result.is_link_lost for result in results.values()):
        return NO_LINK
    return DONE if all(result.is_acknowledged for result in results.values()) else SAID_NO


def parse(words: Sequence[str]) -> list[Wish]:
    """Every word checked; raises `Unfit` with all that is wrong."""
    from protocol.catalogue import SETTINGS

    offered = {command.key: command for command in SETTINGS if command.key in NAMES}
    wishes: dict[str, Wish] = {}
    faults: list[str] = []
    for word in words:
        name, equals, text = word.partition("=")
        command = offered.get(name)
        if not equals:
            faults.append(tr("“{word}” is not of the form NAME=VALUE.", word=word))
        elif command is None or command.write is None:
            faults.append(tr("“{name}” cannot be set; what can: {names}.", name=name, names=", ".join(NAMES)))
        elif name in wishes:
            faults.append(tr("{name} is given twice.", name=name))
        else:
            try:
                wishes[name] = Wish(command, parse_value(command.write, text))
            except ValueError as error:
                faults.append(tr("{name}: {why}.", name=name, why=error))
    if faults:
        raise Unfit("\n".join(faults))
    return list(wishes.values())


def parse_value(field: "Field", text: str) -> "Value":
    """`text` in the field's unit, exactly as it will be sent; raises `ValueError` for what the field cannot carry."""
    from protocol.fields import Done, Flag

    if isinstance(field, Flag | Done):
        value: Value | None = _WORDS.get(text.lower())
        if value is None:
            raise ValueError(tr("“{text}” is neither true nor false", text=text))
    else:
        try:
            value = int(text) if text.lstrip("+-").isdecimal() else float(text)
        except ValueError:
            raise ValueError(tr("“{text}” is no number", text=text)) from None
    field.encode(value)
    return value


def _write(wish: Wish) -> "Procedure[Result]":
    from app.procedure import Ask
    from protocol.events import Answered, Unanswered
    from protocol.messages import Acknowledgement

    outcome = yield Ask(wish.command.set(wish.value))
    if isinstance(outcome, Unanswered):
        return Result(
            wish.value,
            is_acknowledged=False,
            error="not sent: the module stopped answering",
            words=tr("not sent: the module stopped answering"),
            is_link_lost=True,
        )
    if not isinstance(outcome, Answered):
        return Result(
            wish.value,
            is_acknowledged=False,
            error=f"no reply within {outcome.waited_s:.1f} s; it may have been carried out",
            words=tr("no reply within {seconds:.1f} s; it may have been carried out", seconds=outcome.waited_s),
        )
    answer = outcome.messages[0]
    if isinstance(answer, Acknowledgement) and answer.is_accepted:
        return Result(wish.value, is_acknowledged=True)
    raw = f"{getattr(answer, 'raw', 0):02X}"
    return Result(
        wish.value,
        is_acknowledged=False,
        error=f"the module answered {raw} instead",
        words=tr("the module answered {raw} instead", raw=raw),
    )


def _lost(wish: Wish) -> Result:
    return Result(
        wish.value,
        is_acknowledged=False,
        error="the port was lost; it may have been carried out",
        words=tr("the port was lost; it may have been carried out"),
        is_link_lost=True,
    )


def json_of(results: dict[str, Result]) -> dict[str, object]:
    """The object of `dps-s set --json`. Nothing on offer today has a read-back, so nothing is verified."""
    return {
        "results": {
            name: {
                "wanted": result.wanted,
                "acknowledged": result.is_acknowledged,
                "read_back": None,
                "verified": None,
                "error": result.error,
            }
            for name, result in results.items()
        }
    }


def page_of(results: dict[str, Result]) -> list[str]:
    return two_columns([Row(name, _sentence(result)) for name, result in results.items()], indent=0)


def _sentence(result: Result) -> str:
    wanted = str(result.wanted).lower()
    if result.is_acknowledged:
        return tr("{value}: acknowledged (cannot be read back)", value=wanted)
    return tr("{value}: not acknowledged ({why})", value=wanted, why=result.words or "")
