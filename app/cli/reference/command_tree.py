"""Commands with their options and arguments, as plain data from argparse's parsers."""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum

from app.terminal import console

_FILE_PLACES = ("FILE", "DIR", "PATH", "LOG", "P", "HEX")
"""How a help text calls what names a file, a folder or a port."""


class Kind(Enum):
    """What may be typed as a value."""

    NOTHING_KNOWN = "nothing known"
    FILES = "files"
    WORDS = "words"
    SETTINGS = "settings"
    """NAME=VALUE."""


@dataclass(frozen=True, slots=True)
class Argument:
    """Of an option `names` are its flags; without names it is positional."""

    names: tuple[str, ...]
    help: str
    takes_value: bool
    kind: Kind = Kind.NOTHING_KNOWN
    words: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class CommandNode:
    """`path`: the words that lead to it, "recordings export"; "" for the program."""

    path: str
    help: str
    arguments: tuple[Argument, ...]
    commands: tuple["CommandNode", ...] = field(default=())

    @property
    def name(self) -> str:
        return self.path.rpartition(" ")[2]

    @property
    def options(self) -> tuple[Argument, ...]:
        return tuple(one for one in self.arguments if one.names)

    @property
    def values(self) -> tuple[Argument, ...]:
        """What is no option."""
        return tuple(one for one in self.arguments if not one.names)

    def all(self) -> Iterator["CommandNode"]:
        """This one and those below."""
        yield self
        for one in self.commands:
            yield from one.all()


def tree_of(parser: argparse.ArgumentParser, path: str = "", summary: str = "") -> CommandNode:
    """A parser with everything below it."""
    arguments, commands = [], []
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            helps = {one.dest: one.help or "" for one in action._choices_actions}
            commands += [
                tree_of(one, f"{path} {name}".strip(), helps.get(name) or _first_sentence(one.description or ""))
                for name, one in action.choices.items()
            ]
        elif action.help is not argparse.SUPPRESS:
            arguments.append(_argument(action))
    return CommandNode(path, summary, tuple(arguments), tuple(commands))


def _argument(action: argparse.Action) -> Argument:
    help_text = (action.help or "").replace("%%", "%")
    names = tuple(action.option_strings)
    takes_value = action.nargs != 0
    if not takes_value:
        return Argument(names, help_text, takes_value=False)
    if action.choices is not None:
        return Argument(names, help_text, takes_value, Kind.WORDS, tuple(map(str, action.choices)))
    if "--baud" in names:
        return Argument(names, help_text, takes_value, Kind.WORDS, (*map(str, console.RATES), console.AUTO))
    place = action.metavar if isinstance(action.metavar, str) else ""
    if place == "NAME=VALUE":
        return Argument(names, help_text, takes_value, Kind.SETTINGS)
    if place == "yes|no":
        return Argument(names, help_text, takes_value, Kind.WORDS, ("yes", "no"))
    if place.startswith("{"):
        return Argument(names, help_text, takes_value, Kind.WORDS, tuple(place.strip("{}").split(",")))
    is_file = place.partition(".")[0] in _FILE_PLACES
    return Argument(names, help_text, takes_value, Kind.FILES if is_file else Kind.NOTHING_KNOWN)


def _first_sentence(text: str) -> str:
    return text.replace("。", ". ").partition(". ")[0].removesuffix(".")
