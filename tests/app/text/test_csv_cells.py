"""CSV cells: none is a formula in a spreadsheet."""

import pytest

from app.text.csv_cells import cell, defused


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
