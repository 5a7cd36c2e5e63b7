"""Numbers, units and times read alike in both languages, whatever the habits of the computer are."""

import pytest

from app.text.i18n import CHINESE, ENGLISH, set_language, tr
from app.text.messages import duration


@pytest.mark.parametrize(
    ("seconds", "english", "chinese"),
    [
        (0.42, "0.4 s", "0.4 秒"),
        (1.94, "1.9 s", "1.9 秒"),
        (1.96, "2 s", "2 秒"),
        (12, "12 s", "12 秒"),
        (240, "4 min", "4 分钟"),
        (7200, "2 h", "2 小时"),
    ],
)
def test_an_age_is_in_words(seconds: float, english: str, chinese: str) -> None:
    for name, text, ago in ((ENGLISH, english, f"{english} ago"), (CHINESE, chinese, f"{chinese}前")):
        set_language(name)
        assert duration(seconds) == text
        assert tr("{time} ago", time=duration(seconds)) == ago
