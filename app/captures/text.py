"""Reads bytes as text: hex as people paste it, and lines with times, as support bundles show the traffic.

    # started: 2026-11-21T01:49:05Z
    0.000000 > 42 61 32 01 00 33
    0.002913 < 41 75 32 07 0A 00 01 44

Seconds, direction (`>` host to module, `<` module to host), bytes. A line that cannot be read is skipped and reported.
Any other text is hex: two digits make a byte; spaces, commas and line ends may stand between two bytes, and "0x" before
the first of a word. Lines that begin with # are remarks.
"""

import re
from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from typing import Final, NamedTuple, TextIO

from app.captures.entries import CaptureEntry, Way
from app.captures.explained import Explained, Explainer, HexExplainer
from protocol.catalogue import Command
from protocol.translatable import marked

MAX_LINE_LENGTH: Final = 64 * 1024
"""Of a line with a time."""
MAX_TEXT_LENGTH: Final = 1 << 22
"""Of a line of hex."""
MAX_FAULTS: Final = 100
NOT_HEX: Final = marked("no pairs of hex digits")
_ENTRY = re.compile(r"(\d{1,12}(?:\.\d{1,9})?)\s+([<>])\s*(.*)")
_WORD = re.compile(r"[^\s,\ufeff]+")
_SHOWN = 24
"""Characters of a word that is refused."""


class NotHex(ValueError):
    """Text that is not a pair of hex digits; `word` is its beginning."""

    def __init__(self, word: str) -> None:
        super().__init__(f"{word!r} is not a pair of hex digits")
        self.word = word


def hex_bytes(text: str) -> bytes:
    """The bytes of words of whole pairs of digits. Raises `NotHex`."""
    with suppress(ValueError):  # most text has neither commas nor "0x"
        return bytes.fromhex(text)
    raw = bytearray()
    for word in _WORD.findall(text):
        digits = word[2:] if word[:2] in ("0x", "0X") else word
        try:
            raw += bytes.fromhex(digits)
        except ValueError:
            digits = ""
        if not digits:
            raise NotHex(word[:_SHOWN])
    return bytes(raw)


class LineFault(NamedTuple):
    """A line that was skipped. `line` counts from 1; `text` is English, marked."""

    line: int
    text: str


class TimedLines:
    def __init__(self) -> None:
        self.faults: list[LineFault] = []
        """The first `MAX_FAULTS`."""
        self._number = 0
        self._last_s = 0.0

    def feed(self, line: str) -> CaptureEntry | None:
        """None for a remark, an empty line, and one that cannot be read."""
        self._number += 1
        plain = line.strip("\ufeff \t\r\n")
        if not plain or plain.startswith("#"):
            return None
        entry = _ENTRY.fullmatch(plain) if len(line) <= MAX_LINE_LENGTH else None
        if entry is None:
            self._refuse(marked("no time, direction and bytes"))
            return None
        try:
            raw = hex_bytes(entry[3])
        except NotHex:
            self._refuse(NOT_HEX)
            return None
        at_s = float(entry[1])
        if at_s < self._last_s:
            self._refuse(marked("the time runs backwards"))
            at_s = self._last_s
        self._last_s = at_s
        return CaptureEntry(at_s, Way(entry[2]), raw) if raw else None

    def _refuse(self, text: str) -> None:
        if len(self.faults) < MAX_FAULTS:
            self.faults.append(LineFault(self._number, text))


class TextReader:
    """Explains text line by line; its first line that is no remark tells whether it has times."""

    def __init__(self, asked: Command | None = None) -> None:
        """`asked`: the command that the module's frames answer until the first request."""
        self.is_timed = False
        self._has_begun = False
        self._lines, self._explainer = TimedLines(), Explainer(asked)
        self._hex_explainer = HexExplainer(asked)

    @property
    def faults(self) -> list[LineFault]:
        """Of lines with times."""
        return self._lines.faults

    def feed(self, line: str) -> list[Explained]:
        """What the line completes. Raises `NotHex`."""
        plain = line.strip("\ufeff \t\r\n")
        is_remark = not plain or plain.startswith("#")
        if not self._has_begun and not is_remark:
            self._has_begun, self.is_timed = True, _ENTRY.fullmatch(plain) is not None
        if self.is_timed or not self._has_begun:
            entry = self._lines.feed(line)
            return [] if entry is None else self._explainer.feed(entry)
        return [] if is_remark else self._hex_explainer.feed(hex_bytes(line))

    def end(self) -> list[Explained]:
        return self._explainer.end() if self.is_timed else self._hex_explainer.end()


def lines_in(file: TextIO) -> Iterator[str]:
    """Of a text; a line that is too long in pieces."""
    return iter(partial(file.readline, MAX_TEXT_LENGTH), "")
