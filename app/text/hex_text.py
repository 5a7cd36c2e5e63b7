"""Parses pasted hex text incrementally: "41 75", "4175", "0x41, 0x75", across lines.

Two digits make a byte; spaces, commas, line ends and a "0x" may stand between two bytes, nothing else may.
"""

import re

_BYTES = re.compile(r"(?:[\s,\ufeff]|(?:0[xX])?[0-9a-fA-F]{2})*")
_FILLING = re.compile(r"0[xX]|[\s,\ufeff]")
_BEGUN_BYTE = re.compile(r"(?:0[xX])?[0-9a-fA-F]?")
_WORD = re.compile(r"[^\s,]{1,24}")


class NotHex(ValueError):
    """Text that is not a pair of hex digits; `word` is its beginning."""

    def __init__(self, word: str) -> None:
        super().__init__(f"{word!r} is not a pair of hex digits")
        self.word = word


class HexText:
    """Incremental reader; keeps at most three characters between two calls."""

    def __init__(self) -> None:
        self._begun = ""

    def feed(self, text: str) -> bytes:
        """The bytes that `text` completes. Raises `NotHex`, after which the reader cannot be used."""
        text = self._begun + text
        match = _BYTES.match(text)
        end = match.end() if match is not None else 0
        if _BEGUN_BYTE.fullmatch(text, end) is None:
            raise NotHex(_first_word(text[end:]))
        self._begun = text[end:]
        return bytes.fromhex(_FILLING.sub("", text[:end]))

    def finish(self) -> None:
        """Raises `NotHex` when the text ended within a byte."""
        if self._begun:
            raise NotHex(self._begun)


def _first_word(text: str) -> str:
    word = _WORD.match(text)
    return word.group() if word is not None else text[:1]
