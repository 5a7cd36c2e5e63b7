"""The Chinese texts use the terms of the glossary and Chinese typography."""

import re
from collections.abc import Container
from functools import cache
from itertools import takewhile
from pathlib import Path
from typing import Final, NamedTuple

import pytest

from app.text.i18n import CHINESE, read_messages

ROOT: Final = Path(__file__).parents[2]
TS: Final = ROOT / "app" / "locale" / f"{CHINESE}.ts"
DOCUMENTS: Final = tuple(
    page for folder in (ROOT, ROOT / "docs", ROOT / "ui" / "help" / "guide") for page in sorted(folder.glob("*.md"))
)
HAN: Final = "\u3400-\u9fff"
OTHER_SENSE: Final = {
    "Light mode",  # colour themes of the window
}
"""Texts in which a word of the glossary is not used as a term."""
UNITS: Final = ("V", "g", "ms", "km/h", "MB", "kB")
ALWAYS_SEVERAL: Final = {
    "Damaged frames: {rejected} of {bytes} bytes are invalid.",
    "Interrupted {count} times since {time}, last: {why}",
    "The adapter at {port} disconnected {visits} times.",
    "no reply within {seconds:.1f} s, asked {attempts} times",
    "{count} of {total} logs",
    "{count} recordings begin with “{name}”.",
    "{name}: at most {count} characters.",
}
"""Texts whose count is never one, or of the form "n of m"."""
_COUNTED: Final = re.compile(
    r"\{(?:count|n|rows|done|visits|asked|attempts|readings|changes|total|slots|bytes)\} "
    r"(?P<noun>(?:[a-z]+ )?[a-z]{2,})s\b"
)
_FIELD: Final = re.compile(r"\{[^{}]*\}")


class Term(NamedTuple):
    """One row: the English term, its permitted Chinese terms, and the vendor's."""

    english: str
    chinese: tuple[str, ...]
    vendor: str


def terms() -> list[Term]:
    found = []
    for line in (ROOT / "docs" / "internals" / "glossary.md").read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("|") and len(cells) == 4 and cells[0] != "English" and not cells[0].startswith("-"):
            found.append(Term(cells[0], tuple(word.strip() for word in cells[1].split("/")), cells[2]))
    return found


@cache
def pairs() -> dict[str, str]:
    return read_messages(TS)


def without_fields(text: str) -> str:
    """Without placeholders, whose names are not words of the text."""
    return _FIELD.sub(" ", text)


@pytest.mark.parametrize("term", terms(), ids=lambda term: term.english)
def test_a_term_is_always_translated_the_same(term: Term) -> None:
    word = re.compile(rf"(?<![A-Za-z-]){re.escape(term.english)}(?:s|es)?(?![A-Za-z-])", re.IGNORECASE)
    used = 0
    wrong = []
    for english, chinese in pairs().items():
        if english in OTHER_SENSE or not _speaks_of(word, without_fields(english)):
            continue
        used += 1
        if not any(one in chinese for one in term.chinese):
            wrong.append(f"{english!r}: {chinese!r}")
    assert used, f"nothing speaks of {term.english}: take it out of the glossary"
    assert not wrong, "\n".join(wrong)


def _speaks_of(word: re.Pattern[str], english: str) -> bool:
    """Not where it is code: --host, HOST:PORT, the “module on” of “switches the module on” is fine."""
    return any(not re.match(r":[A-Za-z]", english[found.end() :]) for found in word.finditer(english))


@cache
def rows_below(heading: str) -> list[tuple[str, list[str]]]:
    """Rows of the two-column table with this first heading: the forbidden word and its replacement."""
    lines = (ROOT / "docs" / "internals" / "glossary.md").read_text(encoding="utf-8").splitlines()
    start = next(n for n, line in enumerate(lines) if line.startswith(f"| {heading} |")) + 2
    rows = takewhile(lambda line: line.startswith("|"), lines[start:])
    pairs_below = (tuple(map(str.strip, row.strip("|").split("|"))) for row in rows)
    return [(word, instead.split(", ")) for word, instead in pairs_below]


def forbidden_in_english(text: str) -> list[str]:
    """A capitalised word is matched as a whole label, others anywhere."""
    words = [word for cell, _ in rows_below("word") for word in cell.split(", ")]
    spoken = without_fields(text)
    return [
        word
        for word in words
        if (word == text if word[0].isupper() else re.search(rf"(?i)(?<![\w-]){re.escape(word)}(?![\w-])", spoken))
    ]


def forbidden_in_chinese(text: str) -> list[str]:
    return [word for cell, _ in rows_below("中文") for word in cell.split("、") if word in text]


def test_no_text_uses_a_word_that_the_glossary_forbids() -> None:
    found = [
        f"{words}: {english!r}: {chinese!r}"
        for english, chinese in pairs().items()
        if (words := [*forbidden_in_english(english), *forbidden_in_chinese(chinese)])
    ]
    assert not found, "\n".join(found)


def has_wrong_plural(english: str, texts: Container[str]) -> bool:
    """Whether it could read “1 rows”: counts have to follow a colon or have a separate text for one."""
    for found in _COUNTED.finditer(english):
        if english.replace(found[0], f"1 {found['noun']}") not in texts and english not in ALWAYS_SEVERAL:
            return True
    return False


def test_no_text_says_1_rows() -> None:
    texts = pairs()
    assert [english for english in texts if has_wrong_plural(english, texts)] == []
    assert has_wrong_plural("{count} rows saved", ())
    assert not has_wrong_plural("{count} rows saved", ("1 row saved",))
    assert not has_wrong_plural("Rows: {count}", ())


def test_a_chinese_term_stands_for_one_thing() -> None:
    """解除 means to disarm; elsewhere it would say the opposite."""
    wrong = [
        f"{term}: {english!r}: {chinese!r}"
        for term, stems in rows_below("only")
        for english, chinese in pairs().items()
        if term in chinese and not any(stem.lower() in english.lower() for stem in stems)
    ]
    assert not wrong, "\n".join(wrong)


def faults_of_style(english: str, chinese: str) -> list[str]:
    """Errors of Chinese typography."""
    found = []
    if "..." in english or re.search(r"\s…$", english):
        found.append("the ellipsis is one character, with no blank before it")
    if re.search(r"[!！](?![)）])", english + chinese):
        found.append("an exclamation mark")
    if re.search(r"\s[。，；：？]|[。，；：？] ", chinese):
        found.append("a blank at a full-width mark")
    if re.search(r"\b1 (?!ms\b|needs\b)[a-z]{2,}[^s\W]s\b", english):
        found.append("a plural after 1")
    spoken = _FIELD.sub("#", chinese).replace("//主机:端口", "//host:port")
    if re.search(rf"[{HAN}][,;:?!]", spoken):
        found.append("half-width punctuation after a Chinese character")
    if re.search(rf"[{HAN}]\s*\((?![&*][^)]*\))|\([^)&*]*[{HAN}]", chinese):
        found.append("half-width brackets")
    if "……" in chinese or "..." in chinese:
        found.append("an ellipsis is one character")
    if re.search(r"\s…$", chinese) and english.endswith("…"):
        found.append("a blank before the ellipsis")
    if re.search(rf"[{HAN}][^\S\n]+[{HAN}]", spoken) and "  " not in english:
        found.append("a blank between Chinese characters")
    for unit in UNITS:
        number = rf"(?:\d|\}}) {re.escape(unit)}(?![A-Za-z])"
        if len(re.findall(number, english)) != len(re.findall(number, chinese)):
            found.append(f"the unit {unit} is not the same")
    if english.count("°") != chinese.count("°"):
        found.append("degrees are not the same")
    if english.endswith(".") and len(english) > 12 and chinese[-1] not in "。.）！”":
        found.append("a sentence without its full stop")
    if re.search(r"[A-Za-z.]$", english) is not None and chinese.endswith("。") and not english.endswith("."):
        found.append("a full stop that the English has not")
    if chinese == english and "(*" not in english and re.search(r"[a-z]{4,}", spoken):
        found.append("left English")
    return found


def test_the_chinese_is_written_as_chinese_is() -> None:
    found = [
        f"{english!r}: {chinese!r}: {'; '.join(faults)}"
        for english, chinese in pairs().items()
        if (faults := faults_of_style(english, chinese))
    ]
    assert not found, "\n".join(found)


def test_the_vendors_words_are_the_catalogues() -> None:
    """The third column of rows with a code is the text shown beside the setting."""
    from protocol.catalogue import COMMANDS

    words = {f"{command.code:02X}": command.vendor_term for command in COMMANDS}
    for term in terms():
        vendor, _, code = term.vendor.partition(", ")
        if code in ("14", "15", "20", "21", "22", "23", "24", "25", "34", "35"):
            assert vendor in words[code] or words[code] in vendor, term


@pytest.mark.parametrize("page", DOCUMENTS, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_no_document_speaks_of_us(page: Path) -> None:
    """Whoever reads a page cannot know who that is."""
    found = re.findall(r"(?i)\b(?:we|us|ours?|ourselves)\b|我们", page.read_text(encoding="utf-8"))
    assert found == []
