"""The pseudo-language, and the helpers that find cut-off and untranslated texts."""

import string
import subprocess
import sys

import pytest
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget
from pytestqt.qtbot import QtBot

from app.text import i18n
from app.text.i18n import PSEUDO, set_language, tr
from app.text.pseudo_language import pseudo
from tests.support.window.cut_off import cut_off
from tests.support.window.spoken import untranslated
from ui.preferences.dialog import LANGUAGES

SENTENCES = (
    "Tilt", "Measure…", "&File", "{time} ago", "The module is ACTIVE: lock it first.", "Picture (*.png)", "a\nb word",
)  # fmt: skip


@pytest.mark.parametrize("text", SENTENCES)
def test_a_pseudo_text_is_longer_and_keeps_placeholders(text: str) -> None:
    made = pseudo(text)
    assert 1.3 <= len(made) / len(text) <= 1.8
    assert (made[0], made[-1]) == ("[", "]")
    fields = [name for _, name, _, _ in string.Formatter().parse(text)]
    assert [name for _, name, _, _ in string.Formatter().parse(made)] == fields
    for kept in ("&", "…", "*.png", "\n"):
        assert (kept in made) == (kept in text)


def test_units_and_numbers_are_left_alone() -> None:
    assert [pseudo(text) for text in ("{volts:.2f} V", "−{seconds} s", "01", "E3")] == [
        "{volts:.2f} V", "−{seconds} s", "01", "E3",
    ]  # fmt: skip


def test_placeholders_are_filled_in() -> None:
    set_language(PSEUDO)
    assert tr("{time} ago", time="12 s").startswith("[12 s ")
    assert i18n.language() == PSEUDO


def test_it_is_for_developers_only() -> None:
    assert PSEUDO not in i18n.LANGUAGES
    assert PSEUDO not in dict(LANGUAGES)
    words = [sys.executable, "-m", "app", "gui", "--help"]
    told = subprocess.run(words, check=True, capture_output=True, text=True)
    assert PSEUDO not in told.stdout


def test_a_text_that_is_not_translated_is_found(qtbot: QtBot) -> None:
    set_language(PSEUDO)
    row = Row(qtbot, width=500)
    row.label.setText(tr("A text of some length"))
    assert [fault.split(",")[0] for fault in untranslated(row)] == ["QPushButton"]


class Row(QWidget):
    """One label beside one button, for what the finder has to find."""

    def __init__(self, qtbot: QtBot, *, width: int) -> None:
        super().__init__()
        qtbot.addWidget(self)
        self.label, self.button = QLabel("A text of some length"), QPushButton("And a button")
        row = QHBoxLayout(self)
        row.addWidget(self.label)
        row.addWidget(self.button)
        self.setFixedWidth(width)
        self.show()


def test_squeezed_texts_are_found(qtbot: QtBot) -> None:
    assert cut_off(Row(qtbot, width=500)) == []
    narrow = Row(qtbot, width=500)
    narrow.label.setFixedWidth(40)
    narrow.button.setFixedWidth(50)
    found = cut_off(narrow)
    assert len(found) == 2
    assert "A text of some length" in found[0]
    assert "And a button" in found[1]
    narrow.label.setToolTip("A text of some length")
    narrow.button.setAccessibleName("And a button")
    assert cut_off(narrow) == []


def test_overlapping_and_outside_widgets_are_found(qtbot: QtBot) -> None:
    one = QWidget()
    qtbot.addWidget(one)
    one.resize(300, 100)
    first, second, third = (QLabel(text, one) for text in ("one", "two", "three"))
    first.setGeometry(10, 10, 80, 30)
    second.setGeometry(60, 20, 80, 30)
    third.setGeometry(260, 10, 80, 30)
    one.show()
    found = " | ".join(cut_off(one))
    assert "overlap by 30x20" in found
    assert "outside its parent" in found


def test_wrapped_texts_without_height_are_found(qtbot: QtBot) -> None:
    one = QWidget()
    qtbot.addWidget(one)
    label = QLabel("words that need three lines or four", wordWrap=True)
    QVBoxLayout(one).addWidget(label)
    one.setFixedSize(120, 30)
    one.show()
    assert any("of height" in fault for fault in cut_off(one))
