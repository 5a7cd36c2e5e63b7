"""Makes text that people typed, or that came out of a file or from a port, safe to show.

Terminals execute escape characters, and direction marks reorder text: both are shown as code points.
"""

import re
import unicodedata

NEWLINE = "\n"
_LINE_BREAKS = "\t\n\r\v\f\x85\u2028\u2029"
_DIRECTION_MARKS = "\u061c\u200b\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069\ufeff"
_IN_JSON = re.compile("[\x7f-\x9f\u061c\u200b\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ud800-\udfff]")


def visible(text: str, *, keep: str = "") -> str:
    """Return `text` with control characters, direction marks and unpaired surrogates as code points, and with spaces
    for line breaks and tabs; those in `keep` stay."""
    if text.isprintable():
        return text
    return "".join(character if character in keep else _visible(character) for character in text)


def _visible(character: str) -> str:
    if character in _LINE_BREAKS:
        return " "
    if unicodedata.category(character) in ("Cc", "Cs", "Co", "Cn") or character in _DIRECTION_MARKS:
        return f"[U+{ord(character):04X}]"
    return character


def visible_json(text: str) -> str:
    """Return JSON with such characters escaped; `json` has already escaped those below U+0020."""
    return _IN_JSON.sub(lambda match: f"\\u{ord(match[0]):04x}", text)
