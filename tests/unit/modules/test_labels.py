"""A label has what a person and a scanner read, escaped."""

import base64
import re
from datetime import UTC, datetime

import pytest

from app.modules.labels import MAX_NAME_LENGTH, Label, label_body
from app.text.messages import UserError

LABELLED_AT = datetime(2026, 11, 24, tzinfo=UTC)


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("伞仓 07", "伞仓 07"),
        (" <b>&\x1b[31m\u202e ", "&lt;b&gt;&amp;[U+001B][31m[U+202E]"),
        ("M" * MAX_NAME_LENGTH, "M" * MAX_NAME_LENGTH),
    ],
)
def test_a_label_has_name_date_code_and_a_picture(name: str, shown: str) -> None:
    body = label_body(Label(name, LABELLED_AT, "K7QF-3M2X"))
    assert f"<b>{shown}</b>" in body
    assert "<br>2026-11-24<br>K7QF-3M2X<" in body
    picture = re.search(r'src="data:image/png;base64,([^"]+)"', body)
    assert picture is not None
    assert base64.b64decode(picture[1]).startswith(b"\x89PNG")
    assert "<br>2026-11-24</td>" in label_body(
        Label(name, LABELLED_AT)
    )  # no code is better than one of half the settings


@pytest.mark.parametrize("name", ["   ", "M" * (MAX_NAME_LENGTH + 1)])
def test_a_name_that_no_scanner_reads_has_no_label(name: str) -> None:
    with pytest.raises(UserError, match="at most 60"):
        label_body(Label(name, LABELLED_AT))
