"""Pseudo-localisation: English with accents, in brackets and 40 % longer.

It shows problems of a translation in advance: a text that does not go through `tr` has no brackets, one that is cut off
has no closing bracket, and an ASCII-only font or encoding fails. Placeholders, mnemonics, file patterns and line breaks
are kept.
"""

import math
import re
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Final

LONGER: Final = 0.4
"""Typical of German and Russian."""
OPENING: Final = "["
CLOSING: Final = "]"
_ACCENTED: Final = str.maketrans(
    "ABCDEGHIJKLNOPRSTUWYabcdeghijklnoprstuwyz", "ÅßÇÐÉĜĤÎĴĶĻÑÖÞŘŠŢÛŴÝåƀçðéĝĥîĵķļñöþřšţûŵýž"
)
_UNCHANGED: Final = re.compile(r"(\{[^{}]*\}|\([^()]*\*[^()]*\)|\n)")
_WORD: Final = re.compile(r"[A-Za-z]{3,}")
_PADDING: Final = "ôñé ţŵö ţĥřéé ƒöûř ƒîṽé šîx šéṽéñ éîĝĥţ "


@lru_cache(maxsize=4096)
def pseudo(text: str) -> str:
    """`text` in the pseudo-language; one without words, such as "{volts:.2f} V", is unchanged."""
    parts = _UNCHANGED.split(text)
    spoken = parts[::2]
    if not any(_WORD.search(part) for part in spoken):
        return text
    for index in range(0, len(parts), 2):
        parts[index] = parts[index].translate(_ACCENTED)
    length = sum(len(part) for part in spoken)
    missing = max(0, math.ceil(length * LONGER) - len(OPENING + CLOSING))
    padding = (_PADDING * (missing // len(_PADDING) + 1))[:missing].rstrip()
    # A single word grows in one piece, like a compound; a sentence grows by words, so that it can wrap.
    gap = " " if " " in text.strip() else ""
    if not gap:
        padding = padding.replace(" ", "")
    return f"{OPENING}{''.join(parts)}{gap}{padding}{CLOSING}"


class PseudoTexts(Mapping[str, str]):
    """Translates any text on demand, so there is nothing to iterate over."""

    def __getitem__(self, text: str) -> str:
        return pseudo(text)

    def __iter__(self) -> Iterator[str]:
        return iter(())

    def __len__(self) -> int:
        return 0
