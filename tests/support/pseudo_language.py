"""Pseudo-localisation: English with accents, in brackets and 40 % longer.

It shows problems of a translation in advance: a text that does not go through `tr` has no brackets, one that is cut off
has no closing bracket, and an ASCII-only font or encoding fails. Placeholders, mnemonics, file patterns and line breaks
are kept.
"""

import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Final
from xml.sax.saxutils import escape

from app.system.files import write_whole
from app.text.i18n import CHINESE, language, read_messages, set_language, variants

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
_ROOT: Final = Path(__file__).parents[2]


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


def _written() -> str:
    """All texts of the program in the pseudo-language, as a translation at a path that is the same in every process."""
    path = _ROOT / "build" / "pseudo.ts"
    chinese = read_messages(_ROOT / "app" / "locale" / f"{CHINESE}.ts")
    texts = {text for english in chinese for text, _ in variants(english, "")} | {"A text of some length"}
    messages = "".join(
        f"<message><source>{escape(text)}</source><translation>{escape(pseudo(text))}</translation></message>"
        for text in sorted(texts)
    )
    data = f"<TS><context>{messages}</context></TS>".encode()
    path.parent.mkdir(exist_ok=True)
    if not path.is_file() or path.read_bytes() != data:
        write_whole(path, data)
    return str(path)


PSEUDO: Final = _written()
"""As `set_language` takes it."""


@contextmanager
def in_language(name: str) -> Iterator[None]:
    """Use another language for a while, as no program does."""
    before = language()
    set_language(name)
    yield
    set_language(before)
