"""Joins and capitalises sentences in the current language."""

import re
from collections.abc import Iterable
from typing import Final

from app.text.i18n import CHINESE, language

_WIDE_STOP_AND_SPACE: Final = re.compile("([。！？；：]) ")


def begun(text: str) -> str:
    """What is a part of a sentence elsewhere, with a capital at its beginning."""
    return text[:1].upper() + text[1:]


def together(sentences: Iterable[str]) -> str:
    """One after the other. Behind a Chinese full stop, which is as wide as a letter, stands no space."""
    return _WIDE_STOP_AND_SPACE.sub(r"\1", " ".join(one for one in sentences if one))


def listed(names: Iterable[str]) -> str:
    """Names one after the other; Chinese has a comma of its own for that."""
    return ("、" if language() == CHINESE else ", ").join(names)


def aside(text: str) -> str:
    """In brackets, to be put behind a word."""
    return f"（{text}）" if language() == CHINESE else f" ({text})"


def reason_of(error: Exception) -> str:
    """What the system says of it, without its number and the path; else the error's own words."""
    return getattr(error, "strerror", None) or str(error)
