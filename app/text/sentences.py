"""Joins and capitalises sentences in the current language."""

from collections.abc import Iterable

from app.text.i18n import CHINESE, language


def begun(text: str) -> str:
    """What is a part of a sentence elsewhere, with a capital at its beginning."""
    return text[:1].upper() + text[1:]


def together(sentences: Iterable[str]) -> str:
    """One after the other. Behind a Chinese full stop, which is as wide as a letter, stands no space."""
    return " ".join(one for one in sentences if one).replace("。 ", "。")


def listed(names: Iterable[str]) -> str:
    """Names one after the other; Chinese has a comma of its own for that."""
    return ("、" if language() == CHINESE else ", ").join(names)
