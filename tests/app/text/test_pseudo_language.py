"""Nothing is cut off, in either language or in one that is 40 % longer; and every text goes through `tr`."""

import re
import string
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QSize
from PySide6.QtWidgets import QApplication, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget
from pytestqt.qtbot import QtBot

from app.text import i18n
from app.text.i18n import ENGLISH, PSEUDO, set_language, tr
from app.text.pseudo_language import pseudo
from tests.support.window.cut_off import cut_off, cut_off_in_paint
from tests.support.window.painted_text import picture_of, watching
from tests.support.window.spoken import outside_brackets, said_by
from tests.support.window.walk import SMALL_SCREEN, walking
from ui.preferences.dialog import LANGUAGES
from ui.shell.main_window import SMALLEST

SENTENCES = (
    "Tilt", "Measure…", "&File", "{time} ago", "The module is ACTIVE: lock it first.", "Picture (*.png)", "a\nb word",
)  # fmt: skip
SPEAK_FOR_OTHERS = {"port_list", "bundle_text", "profile_title", "profile_about"}
"""Show what an adapter, a file or a profile says of itself; nobody translates that."""
NAMES = re.compile(
    r"DPS-S|USB|UART|Ctrl|Shift|Alt|Esc|Del|Return|Enter|\w+\.(?:json|txt|toml|csv)|\b[0-9A-Z]{4}-[0-9A-Z]{4}\b|tty\w+|\bGO\b|sim://\w+"
    r"|(?:[A-Z]:)?[\\/][\w.\\/~-]+"
)


@pytest.mark.parametrize("text", SENTENCES)
def test_a_pseudo_text_is_longer_and_keeps_what_is_no_language(text: str) -> None:
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


@pytest.mark.parametrize(
    ("language", "size"),
    [(PSEUDO, SMALL_SCREEN), (ENGLISH, SMALLEST)],
    ids=lambda one: one if isinstance(one, str) else f"{one.width()}x{one.height()}",
)
def test_nothing_is_cut_off(qtbot: QtBot, qapp: QApplication, tmp_path: Path, language: str, size: QSize) -> None:
    """And in the pseudo-language nothing is left English."""
    found: dict[str, str] = {}
    english: dict[str, str] = {}
    with walking(qtbot, qapp, tmp_path, language=language, size=size) as walk:
        for stop in walk.stops():
            assert walk.window.size() == size, stop.name
            with watching() as drawn:
                picture_of(stop.root)
            for fault in (*cut_off(stop.root), *cut_off_in_paint(drawn)):
                found.setdefault(fault, stop.name)
            for fault in untranslated(stop.root) if language == PSEUDO else ():
                english.setdefault(fault, stop.name)
    assert not found, "\n".join(f"{name}: {fault}" for fault, name in found.items())
    assert not english, "\n".join(f"{name}: {fault}" for fault, name in english.items())


def untranslated(root: QWidget) -> Iterator[str]:
    for said in said_by(root):
        left = NAMES.sub(" ", outside_brackets(said.text))
        if said.where not in SPEAK_FOR_OTHERS and re.search(r"[A-Za-z]{3,}", left):
            yield f"{said.where}, {said.role}: {said.text!r}"


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


def test_the_finder_finds_what_is_squeezed(qtbot: QtBot) -> None:
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


def test_the_finder_finds_what_lies_on_or_outside(qtbot: QtBot) -> None:
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


def test_the_finder_finds_a_wrapped_text_without_height(qtbot: QtBot) -> None:
    one = QWidget()
    qtbot.addWidget(one)
    label = QLabel("words that need three lines or four", wordWrap=True)
    QVBoxLayout(one).addWidget(label)
    one.setFixedSize(120, 30)
    one.show()
    assert any("of height" in fault for fault in cut_off(one))
