"""Joining sentences and lists in both languages."""

from collections.abc import Iterator

import pytest

from app.text.csv_cells import cell, defused
from app.text.i18n import CHINESE, ENGLISH, set_language
from app.text.messages import UserMessage, joined
from app.text.sentences import capitalised, join_names, join_sentences, with_units


@pytest.fixture(autouse=True)
def in_english_again() -> Iterator[None]:
    yield
    set_language(ENGLISH)


def test_sentences_are_joined_as_in_their_language() -> None:
    assert join_sentences(["Fires at 20°.", "", "Rearms at 10°."]) == "Fires at 20°. Rearms at 10°."
    assert join_sentences(["在 20° 开伞。", "在 10° 复位。"]) == "在 20° 开伞。在 10° 复位。"


def test_names_are_joined_with_the_comma_of_the_language() -> None:
    assert join_names(["Tilt", "Light"]) == "Tilt, Light"
    set_language(CHINESE)
    assert join_names(["倾角", "光线"]) == "倾角、光线"


def test_the_first_letter_becomes_a_capital() -> None:
    assert capitalised("advised: 55° or more.") == "Advised: 55° or more."
    assert capitalised("") == ""


def test_joined_messages_have_the_comma_of_the_language_that_they_are_read_in() -> None:
    both = joined([UserMessage("M-07"), UserMessage("H6"), UserMessage("1, 2")])
    set_language(CHINESE)
    assert both.translated() == "M-07，H6，1, 2"
    assert joined([UserMessage("M-07"), UserMessage("H6")], " + ").translated() == "M-07 + H6"
    set_language(ENGLISH)
    assert both.translated() == both.in_english() == "M-07, H6, 1, 2"
    assert both.to_json()["text"] == "{p0}, {p1}, {p2}"  # as records store it


def test_joined_messages_that_are_sentences_have_the_space_of_the_language() -> None:
    both = joined([UserMessage("Disconnected."), UserMessage("Cancelled.")], " ")
    assert both.translated() == both.in_english() == "Disconnected. Cancelled."
    set_language(CHINESE)
    assert both.translated() == "已断开。已取消。"


def test_a_number_keeps_its_unit() -> None:
    assert with_units("Below 0.5 g for 2.00 s: 3 steps, 低于 0.5 g 达") == (
        "Below 0.5\u00a0g for 2.00\u00a0s: 3 steps, 低于 0.5\u00a0g 达"
    )


# CSV cells: none is a formula in a spreadsheet


@pytest.mark.parametrize(
    "text",
    [
        *("=1+1", "+1", "-1", "@SUM(A1)", "|cmd", "%1", "'=1"),
        *("＝1+1", "＋1", "－1", "＠SUM(A1)"),
        *("\t=1", "\r=1", "  =1", " ＋1"),
    ],
)
def test_no_cell_is_a_formula(text: str) -> None:
    assert defused(text) == f"'{text}"
    assert cell(text) == f"'{text}"
    assert cell([text, 1]) == f"'{text} 1"


@pytest.mark.parametrize("text", ["41 75", "a=1", "", "激活"])
def test_other_text_is_left_as_it_is(text: str) -> None:
    assert defused(text) == cell(text) == text


@pytest.mark.parametrize(
    ("value", "expected"), [(None, ""), (True, "true"), (False, "false"), (-1.5, "-1.5"), (0, "0"), ([1, 2], "1 2")]
)
def test_a_number_stays_a_number(value: object, expected: str) -> None:
    assert cell(value) == expected
