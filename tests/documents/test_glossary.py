"""The Chinese texts use the terms of the glossary and Chinese typography."""

import re
from collections.abc import Iterator
from functools import cache
from itertools import takewhile
from typing import Final

from app.text.i18n import CHINESE, read_messages
from tests.support.processes import ROOT

TS: Final = ROOT / "app" / "locale" / f"{CHINESE}.ts"
GLOSSARY: Final = ROOT / "docs" / "internals" / "glossary.md"
HAN: Final = "\u3400-\u9fff"
OTHER_SENSE: Final = {
    "Light mode",  # colour themes of the window
}
"""Texts in which a word of the glossary is not used as a term."""
_FIELD: Final = re.compile(r"\{[^{}]*\}")


def _rows(is_table: str, columns: int) -> Iterator[list[str]]:
    """The rows below each head of a table that begins so."""
    lines = GLOSSARY.read_text(encoding="utf-8").splitlines()
    for number, line in enumerate(lines):
        if line.startswith(is_table):
            for row in takewhile(lambda line: line.startswith("|"), lines[number + 2 :]):
                cells = [cell.strip() for cell in row.strip("|").split("|")]
                if len(cells) == columns:
                    yield cells


@cache
def pairs() -> dict[str, str]:
    return read_messages(TS)


def without_fields(text: str) -> str:
    """Without placeholders, whose names are not words of the text."""
    return _FIELD.sub(" ", text)


def test_a_term_is_always_translated_the_same() -> None:
    wrong = []
    for term, chinese, *_ in _rows("| English |", 4):
        word = re.compile(rf"(?<![A-Za-z-]){re.escape(term)}(?:s|es)?(?![A-Za-z-]|:[A-Za-z])", re.IGNORECASE)
        spoken = {
            english: said
            for english, said in pairs().items()
            if english not in OTHER_SENSE and word.search(without_fields(english))
        }
        assert spoken, f"nothing speaks of {term}: take it out of the glossary"
        allowed = [one.strip() for one in chinese.split("/")]
        wrong += [f"{term}: {english!r}: {said!r}" for english, said in spoken.items()
                  if not any(one in said for one in allowed)]  # fmt: skip
    assert not wrong, "\n".join(wrong)


def forbidden_in_english(text: str) -> list[str]:
    """A capitalised word is matched as a whole label, others anywhere."""
    words = [word for cell, _ in _rows("| word |", 2) for word in cell.split(", ")]
    spoken = without_fields(text)
    return [
        word
        for word in words
        if (word == text if word[0].isupper() else re.search(rf"(?i)(?<![\w-]){re.escape(word)}(?![\w-])", spoken))
    ]


def test_no_text_uses_a_word_that_the_glossary_forbids() -> None:
    forbidden = [word for cell, _ in _rows("| 中文 |", 2) for word in cell.split("、")]
    found = {
        english: words
        for english, chinese in pairs().items()
        if (words := [*forbidden_in_english(english), *(word for word in forbidden if word in chinese)])
    }
    assert found == {}


def test_a_chinese_term_stands_for_one_thing() -> None:
    """解除 means to disarm; elsewhere it would say the opposite."""
    wrong = [
        f"{term}: {english!r}: {chinese!r}"
        for term, stems in _rows("| only |", 2)
        for english, chinese in pairs().items()
        if term in chinese and not any(stem.lower() in english.lower() for stem in stems.split(", "))
    ]
    assert not wrong, "\n".join(wrong)


def faults_of_style(english: str, chinese: str) -> Iterator[str]:
    """Errors of Chinese typography."""
    spoken = _FIELD.sub("#", chinese).replace("//主机:端口", "//host:port")
    if "..." in english + chinese or "……" in chinese or re.search(r"\s…$", english + chinese):
        yield "the ellipsis is one character, with no blank before it"
    if re.search(r"[!！](?![)）])", english + chinese):
        yield "an exclamation mark"
    if re.search(r"\s[。，；：？]|[。，；：？] ", chinese):
        yield "a blank at a full-width mark"
    if re.search(rf"[{HAN}][,;:?!]", spoken):
        yield "half-width punctuation after a Chinese character"
    if re.search(rf"[{HAN}]\s*\((?![&*][^)]*\))|\([^)&*]*[{HAN}]", chinese):
        yield "half-width brackets"
    if re.search(rf"[{HAN}][^\S\n]+[{HAN}]", spoken) and "  " not in english:
        yield "a blank between Chinese characters"
    for unit in ("V", "g", "ms", "km/h", "MB", "kB"):
        number = rf"(?:\d|\}}) {re.escape(unit)}(?![A-Za-z])"
        if len(re.findall(number, english)) != len(re.findall(number, chinese)):
            yield f"the unit {unit} is not the same"
    if english.count("°") != chinese.count("°"):
        yield "degrees are not the same"
    if english.endswith(".") and len(english) > 12 and chinese[-1] not in "。.）！”":
        yield "a sentence without its full stop"
    if re.search(r"[A-Za-z]$", english) and chinese.endswith("。"):
        yield "a full stop that the English has not"
    if chinese == english and "(*" not in english and re.search(r"[a-z]{4,}", spoken):
        yield "left English"


def test_the_chinese_is_written_as_chinese_is() -> None:
    found = {english: faults for english, said in pairs().items() if (faults := list(faults_of_style(english, said)))}
    assert found == {}
