"""Colours of lines on a terminal, unless the environment variable NO_COLOR is set."""

import os
import sys
from enum import Enum

from app.text.visible_text import NEWLINE, visible


class Colour(Enum):
    """The value is the ANSI code."""

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


class LargeLine(str):
    """A line that `console.write_lines` prints in letters of double size, for somebody at arm's length."""

    __slots__ = ()


def has_colours() -> bool:
    """Whether standard output takes colours."""
    if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb" or not sys.stdout.isatty():
        return False
    return sys.platform != "win32" or "WT_SESSION" in os.environ  # the older console shows the codes


def shown_line(line: str, *, has_colours: bool) -> str:
    """The line without control characters other than those of its colour."""
    text = visible(line, keep=NEWLINE)
    if has_colours and isinstance(line, LargeLine):
        return f"\x1b[1m\x1b#3{text}\n\x1b#4{text}\x1b[0m"  # upper half, lower half; twice where there are none
    return f"\x1b[{line.colour.value}m{text}\x1b[0m" if has_colours and isinstance(line, ColouredLine) else text
