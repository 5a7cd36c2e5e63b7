"""Translates source texts at run time.

The English text is the key. Chinese comes from `locale/zh_CN.ts` (Qt Linguist's format), which is read when it is
first used. A missing or unfinished translation falls back to English, and so does one that cannot be formatted.

`set_language` belongs to one thread, `tr` may be called from any: it reads one reference to an immutable table.
"""

import locale
import logging
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Final, NamedTuple

ENGLISH: Final = "en"
CHINESE: Final = "zh_CN"
LANGUAGES: Final = (ENGLISH, CHINESE)
CONTEXT: Final = "dps-s"

_LOCALE_FOLDER: Final = Path(__file__).parent.parent / "locale"
_log = logging.getLogger(__name__)


class _Language(NamedTuple):
    """The language in use: its name and, for anything but English, its texts by English text."""

    name: str
    texts: Mapping[str, str]


_in_english: Final = _Language(ENGLISH, MappingProxyType({}))
_current: _Language = _in_english
_spoken: ContextVar[_Language | None] = ContextVar("spoken", default=None)
"""Overrides the current one within `temporary_language`."""


def read_translations(path: Path) -> dict[str, str]:
    """The finished translations of one .ts file with their `variants`, by English text. Raises as `read_messages`."""
    texts = read_messages(path)
    capitals_last = sorted(texts.items(), key=lambda pair: pair[0][:1].isupper())
    return {variant: text for pair in capitals_last for variant, text in variants(*pair)} | texts


_read_once: Final = cache(read_translations)
"""For the program's own file, which stays as it is while the program runs; a translator's is read each time."""


def read_messages(path: Path) -> dict[str, str]:
    """The finished translations of one .ts file, by English text.

    Raises OSError when the file cannot be read and ``xml.etree.ElementTree.ParseError`` when it is not XML.
    """
    from xml.etree import ElementTree  # an English run reads none

    texts: dict[str, str] = {}
    for message in ElementTree.parse(path).getroot().iterfind("context/message"):
        translation = message.find("translation")
        if translation is None or translation.get("type") is not None:
            continue
        source, text = message.findtext("source"), translation.text
        if source and text:
            texts[source] = text
    return texts


def variants(english: str, chinese: str) -> Iterator[tuple[str, str]]:
    """The same text with a capital first letter, in capitals, as a sentence, and with the ellipsis of what asks first:
    none of them is translated by itself, unless it means something else."""
    for text in (english, english[:1].upper() + english[1:]):
        yield text, chinese
        if text[-1:].isalnum() or text.endswith("}"):
            yield f"{text}.", f"{chinese}。"
            yield f"{text}…", f"{chinese}…"
    if "{" not in english:
        yield english.upper(), chinese


def set_language(name: str) -> None:
    """Sets the language: "en", "zh_CN", or the path of a .ts file.

    Raises ValueError for any other name. For a .ts file that cannot be read it logs a warning and uses English.
    """
    global _current  # noqa: PLW0603  one reference, replaced as a whole, is what makes tr() thread-safe
    _current = _in_english if name == ENGLISH else _read_language(name)


def _read_language(name: str) -> _Language:
    path = _LOCALE_FOLDER / f"{CHINESE}.ts" if name == CHINESE else Path(name)
    if path.suffix != ".ts":
        raise ValueError(f"language {name!r} is none of {', '.join(LANGUAGES)} and no path of a .ts file")
    try:
        texts = (_read_once if name == CHINESE else read_translations)(path)
    except (OSError, SyntaxError) as error:  # a ParseError is a SyntaxError
        _log.warning("No translations from %s: %s", path, error)
        texts = {}
    return _Language(name, MappingProxyType(texts))


@contextmanager
def temporary_language(name: str) -> Iterator[None]:
    """Uses another language, in this thread and context only. Raises ValueError like `set_language`."""
    chosen = _current if name == _current.name else _in_english if name == ENGLISH else _read_language(name)
    token = _spoken.set(chosen)
    try:
        yield
    finally:
        _spoken.reset(token)


def language() -> str:
    """The name of the language in use; "en" at the start."""
    return (_spoken.get() or _current).name


def tr(text: str, /, **values: object) -> str:
    """The text in the language in use, with `{name}` placeholders filled in by `str.format`.

    Without values it is not formatted, so it may contain braces. Raises KeyError or ValueError only if the English text
    does not fit its values.
    """
    translated = (_spoken.get() or _current).texts.get(text, text)
    if not values:
        return translated
    if translated is not text:
        try:
            return translated.format(**values)
        except (LookupError, ValueError, TypeError, AttributeError) as error:
            _log.warning("Translation of %r cannot be filled in: %r", text, error)
    return text.format(**values)


def system_language(environ: Mapping[str, str] | None = None) -> str:
    """ "zh_CN" if the computer is set to Simplified or unspecified Chinese, else "en".

    Reads the POSIX variables first (`LANGUAGE`, `LC_ALL`, `LC_MESSAGES`, `LANG`) and asks the platform if none is set
    and no `environ` is given.
    """
    variables = os.environ if environ is None else environ
    for variable in ("LC_ALL", "LC_MESSAGES", "LANG"):
        chosen = variables.get(variable, "")
        if chosen:
            break
    # As in gettext, LANGUAGE overrides the language, but not in the C locale.
    if chosen.split(".")[0] not in ("", "C", "POSIX"):
        chosen = variables.get("LANGUAGE", "").split(":")[0] or chosen
    if not chosen and environ is None:
        chosen = locale.getlocale()[0] or ""
    return CHINESE if _is_simplified_chinese(chosen) else ENGLISH


def _is_simplified_chinese(name: str) -> bool:
    plain = name.split(".")[0].split("@")[0].replace("-", "_").lower()
    if plain.startswith("chinese"):  # Windows: "Chinese (Simplified)_China", "Chinese_China"
        return "traditional" not in plain and "taiwan" not in plain
    parts = plain.split("_")
    return parts[0] == "zh" and not {"hant", "tw", "hk", "mo"} & set(parts[1:])
