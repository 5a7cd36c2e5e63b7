"""A message may hold what a stranger wrote."""

from app.text.messages import UserMessage, clean, message, message_from_json


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
