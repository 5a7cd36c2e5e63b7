"""Values as a person types them."""

import pytest

from app.settings.profiles import SETTINGS_BY_KEY
from app.settings.values import MAX_NUMBER_LENGTH, field_of, parse_value
from app.text.user_error import UserError


def parsed(key: str, text: str) -> object:
    return parse_value(field_of(SETTINGS_BY_KEY[key]), text)


@pytest.mark.parametrize(
    ("text", "value"), [("true", True), ("ON", True), ("yes", True), ("False", False), ("off", False), ("no", False)]
)
def test_flags_are_words(text: str, value: bool) -> None:
    assert parsed("attitude_trigger", text) is value


@pytest.mark.parametrize("text", ["", "1", "truth", "enabled"])
def test_other_words_are_no_flags(text: str) -> None:
    with pytest.raises(UserError, match="true, false"):
        parsed("attitude_trigger", text)


@pytest.mark.parametrize(
    ("key", "text", "value"),
    [("attitude_threshold_deg", "60", 60), ("attitude_threshold_deg", "6e1", 60), ("freefall_time_s", "1.60", 1.6),
     ("baud_rate", "9600", 9600)],
)  # fmt: skip
def test_numbers_are_sent_as_typed(key: str, text: str, value: float) -> None:
    assert parsed(key, text) == value


@pytest.mark.parametrize(
    "text", ["", "sixty", "nan", "inf", "60.5", "-1", "1e400", "60.00000000000000001", "9" * (MAX_NUMBER_LENGTH + 1)]
)
def test_nothing_is_rounded_to_a_value(text: str) -> None:
    with pytest.raises(UserError):
        parsed("attitude_threshold_deg", text)
