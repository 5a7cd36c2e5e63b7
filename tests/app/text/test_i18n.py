"""Translation at run time, also with bad translations."""

import logging
import threading
from pathlib import Path
from xml.sax.saxutils import escape

import pytest

from app.text import i18n
from app.text.i18n import set_language, system_language, tr

Messages = dict[str, tuple[str, str]]


def write_ts(path: Path, messages: Messages) -> str:
    """A .ts file of English -> (translation, type or ""); returns its path as text."""
    lines = "".join(
        f"<message><source>{escape(english)}</source>"
        f"<translation{_type_attribute(kind)}>{escape(text)}</translation></message>"
        for english, (text, kind) in messages.items()
    )
    path.write_text(f"<!DOCTYPE TS><TS><context><name>dps-s</name>{lines}</context></TS>", encoding="utf-8")
    return str(path)


def _type_attribute(kind: str) -> str:
    return f' type="{kind}"' if kind else ""


def test_english_is_the_text_itself() -> None:
    assert i18n.language() == "en"
    assert tr("Tilt") == "Tilt"
    assert tr("{name} took {ms:.1f} ms", name="Tilt", ms=2) == "Tilt took 2.0 ms"


def test_braces_without_values_stay() -> None:
    assert tr("a set {1, 2}") == "a set {1, 2}"


def test_finished_translations_are_used_and_others_are_not(tmp_path: Path) -> None:
    messages = {
        "Tilt": ("倾角", ""),
        "Light": ("光线", "unfinished"),
        "Old": ("旧", "vanished"),
        "Empty": ("", ""),
        "a < b & c": ("甲 < 乙 & 丙", ""),
    }
    set_language(write_ts(tmp_path / "pseudo.ts", messages))
    assert [tr(text) for text in ("Tilt", "Light", "Old", "Empty", "Unknown")] == [
        "倾角",
        "Light",
        "Old",
        "Empty",
        "Unknown",
    ]
    assert tr("a < b & c") == "甲 < 乙 & 丙"


@pytest.mark.parametrize("bad", ["{nam} ms", "{name", "{0}", "{name.missing}", "{name:d}", "{name[3}"])
def test_a_translation_that_cannot_be_filled_in_gives_the_english(
    bad: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    set_language(write_ts(tmp_path / "pseudo.ts", {"{name} ms": (bad, "")}))
    with caplog.at_level(logging.WARNING):
        assert tr("{name} ms", name="x") == "x ms"
    assert "cannot be filled in" in caplog.text


def test_an_english_text_that_does_not_fit_its_values_raises() -> None:
    with pytest.raises(KeyError):
        tr("{name}", other=1)


def test_a_broken_file_leaves_english(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    broken = tmp_path / "broken.ts"
    broken.write_text("<TS><context>", encoding="utf-8")
    for path in (broken, tmp_path / "missing.ts"):
        set_language(str(path))
        assert tr("Tilt") == "Tilt"
        assert i18n.language() == str(path)
    assert caplog.text.count("No translations") == 2


def test_an_unknown_language_is_refused_and_changes_nothing() -> None:
    with pytest.raises(ValueError, match="fr"):
        set_language("fr")
    assert i18n.language() == "en"


def test_chinese_can_be_set() -> None:
    set_language("zh_CN")
    assert i18n.language() == "zh_CN"


def test_texts_are_whole_while_another_thread_switches(tmp_path: Path) -> None:
    pseudo = write_ts(tmp_path / "pseudo.ts", {"{a} of {b}": ("{b} 之 {a}", "")})
    seen: set[str] = set()
    is_over = threading.Event()

    def read() -> None:
        while not is_over.is_set():
            seen.add(tr("{a} of {b}", a=1, b=2))

    reader = threading.Thread(target=read, name="reader")
    reader.start()
    for _ in range(50):
        set_language(pseudo)
        set_language("en")
    is_over.set()
    reader.join()
    assert seen <= {"1 of 2", "2 之 1"}
    assert seen


@pytest.mark.parametrize(
    ("environ", "expected"),
    [
        ({}, "en"),
        ({"LANG": "C"}, "en"),
        ({"LANG": "en_US.UTF-8"}, "en"),
        ({"LANG": "zh_CN.UTF-8"}, "zh_CN"),
        ({"LANG": "zh_SG"}, "zh_CN"),
        ({"LANG": "zh"}, "zh_CN"),
        ({"LANG": "zh_CN.GB18030@stroke"}, "zh_CN"),
        ({"LANG": "zh-Hans-CN"}, "zh_CN"),
        ({"LANG": "zh_TW.UTF-8"}, "en"),
        ({"LANG": "zh_Hant_HK"}, "en"),
        ({"LANG": "Chinese (Simplified)_China.936"}, "zh_CN"),
        ({"LANG": "Chinese (Traditional)_Taiwan.950"}, "en"),
        ({"LANG": "zh_CN.UTF-8", "LC_MESSAGES": "en_GB.UTF-8"}, "en"),
        ({"LANG": "en_US.UTF-8", "LC_ALL": "zh_CN.UTF-8"}, "zh_CN"),
        ({"LANG": "en_US.UTF-8", "LANGUAGE": "zh_CN:en"}, "zh_CN"),
        ({"LANG": "C.UTF-8", "LANGUAGE": "zh_CN"}, "en"),
        ({"LC_ALL": "", "LANG": "zh_CN"}, "zh_CN"),
    ],
)
def test_system_language(environ: dict[str, str], expected: str) -> None:
    assert system_language(environ) == expected


def test_system_language_asks_the_platform_where_nothing_is_set(monkeypatch: pytest.MonkeyPatch) -> None:
    for variable in ("LC_ALL", "LC_MESSAGES", "LANG", "LANGUAGE"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setattr("locale.getlocale", lambda: ("Chinese (Simplified)_China", "936"))
    assert system_language() == "zh_CN"
    monkeypatch.setattr("locale.getlocale", lambda: (None, None))
    assert system_language() == "en"
