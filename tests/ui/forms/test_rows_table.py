"""A table of whole rows."""

from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import RowsFilter, RowsModel, TableColumn

COLUMNS = (TableColumn[int]("Name", str), TableColumn[int]("Size", str))
NAME, SIZE = 0, 1


def test_a_list_that_scrolls_has_the_same_columns_as_one_that_does_not(qtbot: QtBot, qapp: QApplication) -> None:
    model = RowsModel(COLUMNS, lambda row: row, str)
    table = RowsTable("rows", RowsFilter(model), row_px=20, sorted_by=NAME, stretched=NAME, spare=SIZE)
    qtbot.addWidget(table)
    table.fit_columns({NAME: "0000", SIZE: "0000"})
    needed_px = sum(table._widths.values())
    table.show()
    seen = []
    for width in range(needed_px - 4, needed_px + 40, 2):
        table.resize(width, 120)
        for count in (1, 50):
            model.show_rows(tuple(range(count)))
            qapp.processEvents()
            table.doItemsLayout()
            assert table.verticalScrollBar().isVisible() == (count > 1)
            seen.append(table.isColumnHidden(SIZE))
        assert seen[-2] == seen[-1], width
    assert set(seen) == {True, False}
