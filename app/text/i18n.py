"""Translates the program's texts. The English text is the key; `locale/zh_CN.ts` (Qt Linguist) has the Chinese.

The language is chosen at the start, before there is another thread, and stays. A translation that is missing or
unfinished falls back to English.
"""

import os
import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Final

ENGLISH: Final = "en"
CHINESE: Final = "zh_CN"
LANGUAGES: Final = (ENGLISH, CHINESE)

TRANSLATIONS: Final = Path(__file__).parent.parent / "locale" / f"{CHINESE}.ts"
_language: str = ENGLISH
_texts: Mapping[str, str] = {}


def set_language(name: str) -> None:
    """Set the language, one of `LANGUAGES`. Raises ValueError for another name."""
    global _language, _texts  # noqa: PLW0603  the language of the process
    if name not in LANGUAGES:
        raise ValueError(f"language {name!r} is none of {', '.join(LANGUAGES)}")
    _language = name
    _texts = {} if name == ENGLISH else read_translations(TRANSLATIONS)


def language() -> str:
    return _language


def tr(text: str, /, **values: object) -> str:
    """The text in the language in use, with its `{name}` place-holders filled in by `str.format`; without values it is
    not formatted, so it may contain braces."""
    translated = _texts.get(text, text)
    return translated.format(**values) if values else translated


@cache
def read_translations(path: Path) -> Mapping[str, str]:
    """The translations of one .ts file with their variants."""
    messages = read_messages(path)
    # Where two texts have the same variant, that of the one with a capital first letter is the last, which stays.
    capitals_last = sorted(messages.items(), key=lambda pair: pair[0][:1].isupper())
    return {variant: chinese for pair in capitals_last for variant, chinese in variants(*pair)} | messages


def read_messages(path: Path) -> dict[str, str]:
    """The finished translations of one .ts file, by English text. Raises OSError, or SyntaxError for no XML."""
    from xml.etree import ElementTree  # an English run reads none

    texts: dict[str, str] = {}
    for message in ElementTree.parse(path).getroot().iterfind("context/message"):
        source, translation = message.findtext("source"), message.find("translation")
        if source and translation is not None and translation.text and translation.get("type") is None:
            texts[source] = translation.text
    return texts


def variants(english: str, chinese: str) -> Iterator[tuple[str, str]]:
    """Return the texts that need no translation of their own: with a capital first letter, in capitals, as a sentence,
    and with the ellipsis of what asks first."""
    for text in (english, english[:1].upper() + english[1:]):
        yield text, chinese
        if text[-1:].isalnum() or text.endswith("}"):
            yield f"{text}.", f"{chinese}。"
            yield f"{text}…", f"{chinese}…"
    if "{" not in english:
        yield english.upper(), chinese


def system_language(environ: Mapping[str, str] = os.environ) -> str:
    """Chinese if the computer is set to Simplified or unspecified Chinese, else English. The POSIX variables decide;
    where none is set, as on Windows, the platform does."""
    chosen = environ.get("LC_ALL") or environ.get("LC_MESSAGES") or environ.get("LANG") or ""
    # As in gettext, LANGUAGE overrides the language, but not in the C locale.
    if chosen.partition(".")[0] not in ("", "C", "POSIX"):
        chosen = environ.get("LANGUAGE", "").partition(":")[0] or chosen
    if not chosen:
        import locale  # loaded only where no variable says it

        chosen = locale.getlocale()[0] or ""
    plain = re.split("[.@]", chosen)[0].lower()
    is_chinese = re.match("zh(_|-|$)|chinese", plain)  # Windows: "Chinese (Simplified)_China"
    return CHINESE if is_chinese and not re.search("traditional|hant|tw|hk|mo", plain) else ENGLISH
