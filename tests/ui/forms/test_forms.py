"""A table of whole rows; the number of a setting: what can be typed into it, and what it shows."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from protocol.catalogue import BY_NAME
from protocol.fields import Value
from ui.core.texts import Texts
from ui.forms.field_editors import NumberEditor, make_editor
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import TableColumn

COLUMNS = (
    TableColumn[int]("Name", str, widest=lambda: "0000", stretches=True),
    TableColumn[int]("Size", str, widest=lambda: "0000", is_spare=True),
)
NAME, SIZE = 0, 1


def test_a_list_that_scrolls_has_the_same_columns_as_one_that_does_not(qtbot: QtBot, qapp: QApplication) -> None:
    table = RowsTable(Texts(), "rows", "", COLUMNS, lambda row: row, str, row_px=20, sorted_by=NAME)
    qtbot.addWidget(table)
    needed_px = sum(table._widths.values())
    table.show()
    seen = []
    for width in range(needed_px - 4, needed_px + 40, 2):
        table.resize(width, 120)
        for count in (1, 50):
            table.show_rows(range(count))
            qapp.processEvents()
            table.doItemsLayout()
            assert table.verticalScrollBar().isVisible() == (count > 1)
            seen.append(table.isColumnHidden(SIZE))
        assert seen[-2] == seen[-1], width
    assert set(seen) == {True, False}


@pytest.fixture
def made(qtbot: QtBot) -> tuple[NumberEditor, list[Value]]:
    """Of the free-fall time, 0.00 s to 2.55 s, and what was chosen in it."""
    editor = make_editor(BY_NAME["freefall_time"], Texts())
    assert isinstance(editor, NumberEditor)
    qtbot.addWidget(editor)
    chosen: list[Value] = []
    editor.chosen.connect(chosen.append)
    return editor, chosen


@pytest.mark.parametrize(
    ("typed", "shown"),
    [
        *((text, "1.2") for text in ("１．２", "１。２", "１，２", "1,2", "1.2", "1.2s", "１．２ｓ")),
        ("1.20", "1.20"), ("2.56", "2.5"), ("-1", "1"), ("six", ""), ("0.555", "0.55"), ("1.2 V", "1.2"), ("256", "2"),
    ],
)  # fmt: skip
def test_only_what_can_be_sent_can_be_typed(made: tuple[NumberEditor, list[Value]], typed: str, shown: str) -> None:
    editor, chosen = made
    for letter in typed:
        editor.line.insert(letter)
    assert editor.line.text() == shown
    assert chosen[-1:] == ([float(shown)] if shown else [])


def test_what_is_typed_is_not_completed_under_the_hand(qtbot: QtBot, made: tuple[NumberEditor, list[Value]]) -> None:
    editor, chosen = made
    editor.show_value(None, 1.6)
    assert (editor.line.text(), editor.box.property("role")) == ("1.60", "muted")
    editor.line.selectAll()
    qtbot.keyClicks(editor.line, "2.")
    editor.show_value(chosen[-1], 1.6)
    assert (editor.line.text(), editor.box.property("role"), chosen) == ("2.", "", [2.0])
    editor.show_value(None, None)  # nothing is known: nothing that looks like a value
    assert (editor.line.text(), editor.box.text()) == ("", "")
    qtbot.keyClick(editor.box, Qt.Key.Key_Up)
    assert chosen[-1] == 1.61  # from the vendor's default
