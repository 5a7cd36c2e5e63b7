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

from app.captures.traffic import CaptureEntry, Explained, Explainer, Way
from protocol.catalogue import Command
from protocol.translatable import marked

MAX_TEXT_LENGTH: Final = 1 << 22
"""Of a line; a longer one is read in pieces."""
MAX_FAULTS: Final = 100
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


class TextReader:
    """Explains text line by line; its first line that is no remark tells whether it has times."""

    def __init__(self, asked: Command | None = None) -> None:
        """`asked`: the command that the module's frames answer until the first request."""
        self._is_timed = False
        self.faults: list[LineFault] = []
        """Of lines with times: the first `MAX_FAULTS`."""
        self._explainer = Explainer(asked)
        self._has_begun = False
        self._number = 0
        self._last_s = 0.0

    def feed(self, line: str) -> list[Explained]:
        """What the line completes. Raises `NotHex` where the text has no times."""
        self._number += 1
        plain = line.strip("\ufeff \t\r\n")
        if not plain or plain.startswith("#"):
            return []
        if not self._has_begun:
            self._has_begun, self._is_timed = True, _ENTRY.fullmatch(plain) is not None
        if not self._is_timed:
            return self._explainer.feed_untimed(hex_bytes(plain))
        entry = self._entry(plain)
        return [] if entry is None else self._explainer.feed(entry)

    def end(self) -> list[Explained]:
        return self._explainer.end()

    def _entry(self, plain: str) -> CaptureEntry | None:
        """The bytes of a line with a time; None where it has none, or cannot be read."""
        found = _ENTRY.fullmatch(plain)
        if found is None:
            self._refuse(marked("no time, direction and bytes"))
            return None
        try:
            raw = hex_bytes(found[3])
        except NotHex:
            self._refuse(marked("no pairs of hex digits"))
            return None
        if float(found[1]) < self._last_s:
            self._refuse(marked("the time runs backwards"))  # its bytes count all the same
        self._last_s = max(self._last_s, float(found[1]))
        return CaptureEntry(self._last_s, Way(found[2]), raw) if raw else None

    def _refuse(self, text: str) -> None:
        if len(self.faults) < MAX_FAULTS:
            self.faults.append(LineFault(self._number, text))


def lines_in(file: TextIO) -> Iterator[str]:
    return iter(partial(file.readline, MAX_TEXT_LENGTH), "")
