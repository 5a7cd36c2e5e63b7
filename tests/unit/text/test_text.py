"""Translation at run time; joining sentences and lists in both languages."""

from collections.abc import Iterator
from pathlib import Path
from xml.sax.saxutils import escape

import pytest

from app.text.csv_cells import cell
from app.text.i18n import CHINESE, ENGLISH, read_messages, set_language, system_language, tr
from app.text.messages import UserMessage, clean, duration, joined, message, message_from_json, with_units

Messages = dict[str, tuple[str, str]]


def write_ts(path: Path, messages: Messages) -> Path:
    """A .ts file of English -> (translation, its attributes); returns its path."""
    lines = "".join(
        f"<message><source>{escape(english)}</source><translation{kind}>{escape(text)}</translation></message>"
        for english, (text, kind) in messages.items()
    )
    path.write_text(f"<!DOCTYPE TS><TS><context><name>dps-s</name>{lines}</context></TS>", encoding="utf-8")
    return path


def test_finished_translations_are_used_and_others_are_not(tmp_path: Path) -> None:
    messages = {
        "Tilt": ("倾角", ""),
        "Light": ("光线", ' type="unfinished"'),
        "Old": ("旧", ' type="vanished"'),
        "Empty": ("", ""),
        "a < b & c": ("甲 < 乙 & 丙", ""),
    }
    assert read_messages(write_ts(tmp_path / "pseudo.ts", messages)) == {"Tilt": "倾角", "a < b & c": "甲 < 乙 & 丙"}


def test_a_language_that_is_not_there_is_refused() -> None:
    with pytest.raises(ValueError, match="none of en, zh_CN"):
        set_language("de")
    set_language(CHINESE)
    assert [tr(text) for text in ("no such text", "{value} ms", "Yes")] == ["no such text", "{value} ms", "是"]


@pytest.mark.parametrize(
    ("environ", "expected"),
    [
        ({}, "en"),
        ({"LANG": "zh_CN.GB18030@stroke"}, "zh_CN"),
        ({"LANG": "zh-Hans-CN"}, "zh_CN"),
        ({"LANG": "Chinese (Simplified)_China.936"}, "zh_CN"),
        ({"LANG": "Chinese (Traditional)_Taiwan.950"}, "en"),
        ({"LANG": "zh_CN.UTF-8", "LC_MESSAGES": "en_GB.UTF-8"}, "en"),
        ({"LANG": "en_US.UTF-8", "LC_ALL": "zh_CN.UTF-8"}, "zh_CN"),
        ({"LANG": "en_US.UTF-8", "LANGUAGE": "zh_CN:en"}, "zh_CN"),
        ({"LANG": "C.UTF-8", "LANGUAGE": "zh_CN"}, "en"),
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


# Sentences and lists


@pytest.fixture(autouse=True)
def in_english_again() -> Iterator[None]:
    yield
    set_language(ENGLISH)


def test_joined_messages_have_the_comma_of_the_language_that_they_are_read_in() -> None:
    both = joined([UserMessage("M-07"), UserMessage("H6"), UserMessage("1, 2")])
    set_language(CHINESE)
    assert both.translated() == "M-07，H6，1, 2"
    assert joined([UserMessage("M-07"), UserMessage("H6")], " + ").translated() == "M-07 + H6"
    set_language(ENGLISH)
    assert both.translated() == both.in_english() == "M-07, H6, 1, 2"
    assert both.to_json()["text"] == "{p0}, {p1}, {p2}"  # as records store it


def test_sentences_have_the_space_of_the_language_and_a_number_keeps_its_unit() -> None:
    both = joined([UserMessage("A jolt may fire it."), UserMessage("Choose a port.")], " ")
    assert both.translated() == both.in_english() == "A jolt may fire it. Choose a port."
    set_language(CHINESE)
    assert both.translated() == "颠簸即可能触发。请选择串口。"
    assert with_units("Below 0.5 g for 2.00 s: 3 steps, 低于 0.5 g 达") == (
        "Below 0.5\u00a0g for 2.00\u00a0s: 3 steps, 低于 0.5\u00a0g 达"
    )


# CSV cells: none is a formula in a spreadsheet


@pytest.mark.parametrize("text", ["=1+1", " =1+1", "-1", "@SUM(A1)", "|cmd", "'=1", "＝1+1", "\t=1", "\r\n=1"])
def test_no_cell_is_a_formula(text: str) -> None:
    assert cell(text) == f"'{text}"
    assert cell([text, 1]) == f"'{text} 1"


@pytest.mark.parametrize(("value", "expected"), [(None, ""), (False, "false"), (-1.5, "-1.5"), ([1, 2], "1 2")])
def test_a_number_stays_a_number(value: object, expected: str) -> None:
    assert cell(value) == expected


# A message may hold what a stranger wrote


def test_placeholders_in_what_is_filled_in_are_not_filled() -> None:
    assert message("{a} {b}", a="{b}", b="2").translated() == "{b} 2"
    assert UserMessage("{missing}").in_english() == "{missing}"
    assert message("{seconds:.1f} s old", seconds=3.14).in_english() == "3.1 s old"


def test_a_message_is_the_same_after_it_was_kept() -> None:
    both = message("{one} {other}", one=message("x"), other="y")
    assert message_from_json(both.to_json()) == both


def test_a_text_is_cleaned_to_one_short_visible_line() -> None:
    assert clean("\u202eabc\n") == "[U+202E]abc "
    assert len(clean("x" * 1000)) == 400


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.42, "0.4 s"), (1.96, "2 s"), (12, "12 s"), (240, "4 min"), (7200, "2 h")],
)
def test_an_age_is_in_words(seconds: float, text: str) -> None:
    assert duration(seconds) == text
