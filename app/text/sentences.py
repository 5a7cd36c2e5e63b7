"""Joins, splits and capitalises sentences in the current language."""

import re
from collections.abc import Iterable
from typing import Final

from app.text.i18n import CHINESE, language, tr

_WIDE_STOP_AND_SPACE: Final = re.compile("([。！？；：]) ")
_BEFORE_UNIT: Final = re.compile(r"(?<=\d) (?=(?:g|V|s|m|km/h)\b)")


def capitalised(text: str) -> str:
    return text[:1].upper() + text[1:]


def join_sentences(sentences: Iterable[str]) -> str:
    """Joins sentences; no space follows full-width Chinese punctuation."""
    return _WIDE_STOP_AND_SPACE.sub(r"\1", " ".join(sentence for sentence in sentences if sentence))


def join_names(names: Iterable[str]) -> str:
    """Joins names with the comma of the language in use."""
    return ("、" if language() == CHINESE else ", ").join(names)


def labelled(label: object, text: object) -> str:
    """`text` after its label, with the colon of the language in use."""
    return f"{label}：{text}" if language() == CHINESE else f"{label}: {text}"


def in_brackets(text: str) -> str:
    """`text` in the parentheses of the language in use, to be appended to a word."""
    return f"（{text}）" if language() == CHINESE else f" ({text})"


def with_units(text: str) -> str:
    """`text`, whose numbers keep their units on their line."""
    return _BEFORE_UNIT.sub("\u00a0", text)


def not_written(file: object, error: Exception) -> str:
    """`error`: a `UserError`, whose own sentence says it, OSError, or ValueError for an invalid name."""
    why = tr("{file} cannot be written: {why}.", file=file, why=error_text(error))
    return getattr(error, "sentence", why)


def saved_text(path: object, rows: int, *, is_whole: bool = True) -> str:
    """`is_whole`: no older rows were gone by then."""
    if is_whole:
        return tr("Saved to {path}. Rows: {rows}.", rows=f"{rows:,}", path=path)
    return tr("Saved to {path}. Rows: {rows}; older ones are gone.", rows=f"{rows:,}", path=path)


def error_text(error: Exception) -> str:
    """The system's message without error number and path, the sentence of a `UserError`, else the text of the error."""
    return getattr(error, "strerror", None) or getattr(error, "sentence", None) or str(error)
