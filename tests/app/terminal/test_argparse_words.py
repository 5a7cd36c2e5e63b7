"""What argparse says by itself is Chinese too, and right where a Python words it otherwise."""

import argparse
import gettext
import inspect
import re
from collections.abc import Iterator

import pytest

from app import __main__ as program
from app.terminal.argparse_words import WORDS, translate_argparse
from app.text.i18n import CHINESE, set_language, tr


@pytest.fixture(autouse=True)
def own_words() -> Iterator[None]:
    translate_argparse()
    yield
    argparse._ = gettext.gettext  # type: ignore[attr-defined]
    argparse.ngettext = gettext.ngettext  # type: ignore[attr-defined]


def test_every_sentence_is_one_of_argparses() -> None:
    """Word for word: else it would never be asked for. Later Pythons have some in other words."""
    source = re.sub(r"'\s*\n\s*'", "", inspect.getsource(argparse)).replace("\\n", "\n")
    unknown = [word for word in WORDS if repr(word)[1:-1].replace("\\n", "\n") not in source]
    assert len(unknown) <= 2, unknown


def test_placeholders_are_the_same() -> None:
    set_language(CHINESE)
    for word in WORDS:
        wanted = sorted(re.findall(r"%(?:\(\w+\))?[sr]", word))
        assert sorted(re.findall(r"%(?:\(\w+\))?[sr]", tr(word))) == wanted, word
        assert word.endswith("\n") == tr(word).endswith("\n")


def test_help_and_errors_are_chinese(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("LC_ALL", "zh_CN.UTF-8")
    assert program.main(["read", "--help"]) == 0
    told = capsys.readouterr().out
    assert told.startswith("用法：dps-s read")
    assert not re.search(r"usage|options|show this help", told)
    for words in (["read", "--port", "x", "--what"], ["archive", "bogus"], ["gui", "--lang", "fr"]):
        assert program.main(words) == 2
        said = capsys.readouterr().err
        assert "错误：" in said
        assert not re.search(r"usage:|error:|invalid|required|unrecognized", said), said


def test_what_is_not_known_stays_english() -> None:
    set_language(CHINESE)
    ask = argparse._  # type: ignore[attr-defined]
    assert ask("a sentence of a later Python") == "a sentence of a later Python"
    assert argparse.ngettext("expected %s argument", "expected %s arguments", 2) == tr(  # type: ignore[attr-defined]
        "expected %s arguments"
    )
