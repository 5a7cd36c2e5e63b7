"""A table of whole rows; the number of a setting: what can be typed into it, and what it shows."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QInputMethodEvent
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from protocol.catalogue import BY_NAME, SETTINGS, Command
from protocol.fields import Quantity, Value
from ui.forms.field_editors import NumberEditor, make_editor
from ui.widgets.number_line import Dial, NumberKind

NAME, SIZE = 0, 1


@pytest.fixture
def made(qtbot: QtBot) -> tuple[NumberEditor, list[Value]]:
    """Of the free-fall time, 0.00 s to 2.55 s, and what was chosen in it."""
    editor = make_editor(BY_NAME["freefall_time"])
    assert isinstance(editor, NumberEditor)
    qtbot.addWidget(editor)
    chosen: list[Value] = []
    editor.chosen.connect(chosen.append)
    return editor, chosen


@pytest.mark.parametrize("typed", ["１．２", "１。２", "１，２", "1,2", "1.2", "1.2s", "１．２ｓ", "1.20", " 1.2 s"])
def test_a_number_may_be_typed_in_many_ways(
    qapp: QApplication, made: tuple[NumberEditor, list[Value]], typed: str
) -> None:
    editor, chosen = made
    commit = QInputMethodEvent()  # as an input method hands over what was typed
    commit.setCommitString(typed)
    qapp.sendEvent(editor, commit)
    assert editor.text() == typed
    assert chosen[-1:] == [1.2]
    assert not editor.is_wrong


def test_what_was_typed_is_chosen_to_the_last_step(qtbot: QtBot, made: tuple[NumberEditor, list[Value]]) -> None:
    """0.29 times 100 is a little less than 29."""
    editor, chosen = made
    qtbot.keyClicks(editor, "0.29")
    assert chosen[-1] == 0.29


@pytest.mark.parametrize("typed", ["16", "2.56", "256", "-1", "six", "0.555", "1.2 V", "1e0", "1.2.3", "nan", "9" * 60])
def test_what_cannot_be_sent_stays_as_typed_in_red(
    qtbot: QtBot, made: tuple[NumberEditor, list[Value]], typed: str
) -> None:
    """650 once became 65, 300 became 30, and 16 seconds became 1.00 s."""
    editor, _chosen = made
    said: list[str] = []
    editor.mistyped.connect(said.append)
    qtbot.keyClicks(editor, typed)
    assert editor.text() == typed
    assert editor.property("role") == "wrong"
    assert said[-1] == typed
    qtbot.keyClick(editor, Qt.Key.Key_Up)  # an arrow key does not correct it either
    assert editor.text() == typed


def test_what_is_typed_is_not_completed_under_the_hand(qtbot: QtBot, made: tuple[NumberEditor, list[Value]]) -> None:
    editor, chosen = made
    editor.show_value(None, 1.6)
    assert (editor.text(), editor.property("role")) == ("1.60", "muted")
    editor.selectAll()
    qtbot.keyClicks(editor, "2.")
    editor.show_value(chosen[-1], 1.6)
    assert (editor.text(), editor.property("role"), chosen) == ("2.", "", [2.0, 2.0])
    editor.show_value(None, None)  # nothing is known: nothing that looks like a value
    assert editor.text() == ""
    qtbot.keyClick(editor, Qt.Key.Key_Up)
    assert chosen[-1] == 1.61  # from the vendor's default


@pytest.mark.parametrize(("key", "number"), [(Qt.Key.Key_PageUp, "2.55"), (Qt.Key.Key_Down, "2.53")])
def test_the_arrow_keys_stay_within_the_range(
    qtbot: QtBot, made: tuple[NumberEditor, list[Value]], key: Qt.Key, number: str
) -> None:
    editor, _chosen = made
    editor.show_value(None, 2.54)
    qtbot.keyClick(editor, key)
    assert editor.text() == number


@pytest.mark.parametrize("command", [command for command in SETTINGS if isinstance(command.write, Quantity)])
def test_every_value_of_the_module_can_be_typed(command: Command) -> None:
    assert isinstance(command.write, Quantity)
    kind = NumberKind.of_field(command.write)
    for raw in range(256):
        value = float(command.write.decode(raw))
        assert kind.read(kind.shown(value)) == value
        assert kind.read(command.write.text(raw)) == value


def test_a_dial_keeps_its_value_while_what_is_typed_cannot_be_used(qtbot: QtBot) -> None:
    dial = Dial("tilt", minimum=0, maximum=180, step=1, unit="°")
    qtbot.addWidget(dial)
    turned: list[float] = []
    dial.turned.connect(turned.append)
    dial.set_value(60)
    dial.show()
    dial.box.selectAll()
    qtbot.keyClicks(dial.box, "650")
    assert dial.box.text() == "650"
    assert (dial.is_wrong, dial.value, dial.slider.value()) == (True, 65, 65)
    assert (dial.range.isVisible(), dial.range.text()) == (True, "0° to 180°, in steps of 1°")
    qtbot.keyClick(dial.box, Qt.Key.Key_Backspace)
    assert (dial.is_wrong, dial.range.isVisible(), turned[-1]) == (False, False, 65)
