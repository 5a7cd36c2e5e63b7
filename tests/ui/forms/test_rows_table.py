"""A table of whole rows."""

from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from ui.core.texts import Texts
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
