"""Numbers, units and times read alike in both languages, whatever the habits of the computer are."""

from collections.abc import Iterator

import pytest
from PySide6.QtCore import QLocale
from PySide6.QtWidgets import QApplication, QDoubleSpinBox
from pytestqt.qtbot import QtBot

from app.system.wall_clock import DAY, local_time
from app.text.durations import duration
from app.text.i18n import CHINESE, ENGLISH, set_language, tr
from tests.support.pseudo_language import PSEUDO
from ui.core.language import use_language


@pytest.fixture(params=[ENGLISH, CHINESE])
def language(request: pytest.FixtureRequest) -> str:
    name = str(request.param)
    set_language(name)
    return name


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


def test_a_day_is_that_of_this_computer(in_china: None) -> None:
    assert local_time("2026-11-20T16:03:07+00:00", DAY) == "2026-11-21"
    assert [local_time(text, DAY) for text in ("soon", "9999-12-31T23:59:59+00:00")] == [
        "soon",
        "9999-12-31T23:59:59+00:00",
    ]


@pytest.fixture
def german_computer() -> Iterator[None]:
    before = QLocale()
    QLocale.setDefault(QLocale("de_DE"))
    yield
    QLocale.setDefault(before)


@pytest.mark.parametrize("name", [ENGLISH, CHINESE, PSEUDO])
def test_fields_have_a_point_on_a_computer_with_a_comma(
    qtbot: QtBot, qapp: QApplication, german_computer: None, name: str
) -> None:
    """What is shown beside a field with a point must be typed with one too."""
    use_language(qapp, name)
    try:
        box = QDoubleSpinBox()
        qtbot.addWidget(box)
        box.setMaximum(5000)
        box.setValue(1234.5)
        assert box.text() == "1234.50"
        assert box.valueFromText("1.6") == 1.6
    finally:
        use_language(qapp, ENGLISH)
