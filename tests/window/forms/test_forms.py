"""The number of a setting: what can be typed into it, and what it shows."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QInputMethodEvent
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from protocol.catalogue import BY_NAME, SETTINGS, Command
from protocol.fields import Quantity
from ui.widgets.number_line import Dial, NumberKind, NumberLine


@pytest.fixture
def made(qtbot: QtBot) -> NumberLine:
    """Of the free-fall time, 0.00 s to 2.55 s; the vendor's default is 1.60 s."""
    field = BY_NAME["freefall_time"].write
    assert isinstance(field, Quantity)
    line = NumberLine(NumberKind.of_field(field), start=1.6, may_be_empty=True)
    qtbot.addWidget(line)
    return line


@pytest.mark.parametrize("typed", ["１．２", "１。２", "１，２", "1,2", "1.2", "1.2s", "１．２ｓ", "1.20", " 1.2 s"])
def test_a_number_may_be_typed_in_many_ways(qapp: QApplication, made: NumberLine, typed: str) -> None:
    commit = QInputMethodEvent()  # as an input method hands over what was typed
    commit.setCommitString(typed)
    qapp.sendEvent(made, commit)
    assert (made.text(), made.number, made.is_wrong) == (typed, 1.2, False)


@pytest.mark.parametrize("typed", ["16", "2.56", "256", "-1", "six", "0.555", "1.2 V", "1e0", "1.2.3", "nan", "9" * 60])
def test_what_cannot_be_sent_stays_as_typed_in_red(qtbot: QtBot, made: NumberLine, typed: str) -> None:
    """650 once became 65, 300 became 30, and 16 seconds became 1.00 s."""
    qtbot.keyClicks(made, typed)
    assert (made.text(), made.number, made.property("role")) == (typed, None, "wrong")
    qtbot.keyClick(made, Qt.Key.Key_Up)  # an arrow key does not correct it either
    assert made.text() == typed


def test_what_is_typed_is_not_completed_under_the_hand(qtbot: QtBot, made: NumberLine) -> None:
    made.show_number(1.6, "muted")
    assert (made.text(), made.property("role")) == ("1.60", "muted")
    made.selectAll()
    qtbot.keyClicks(made, "2.")
    made.show_number(2.0)
    assert (made.text(), made.property("role")) == ("2.", "")
    made.show_number(None)  # nothing is known: nothing that looks like a value
    assert made.text() == ""
    qtbot.keyClick(made, Qt.Key.Key_Up)
    assert made.number == 1.61


@pytest.mark.parametrize(("key", "number"), [(Qt.Key.Key_PageUp, "2.55"), (Qt.Key.Key_Down, "2.53")])
def test_the_arrow_keys_stay_within_the_range(qtbot: QtBot, made: NumberLine, key: Qt.Key, number: str) -> None:
    made.show_number(2.54)
    qtbot.keyClick(made, key)
    assert made.text() == number


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
