"""How a trigger record stands in the list."""

import pytest
from PySide6.QtWidgets import QApplication

from app.trigger_records.kept import SeenRecord
from protocol.messages import TriggerRecord
from ui.pages.triggers.model import COLUMNS, Column
from ui.session.trigger_reading import TriggerRow

RECORD = TriggerRecord(8, 100, ("attitude",), 60, 0.5, 1.6, True, False, 1.2, 3.9, b"")


@pytest.mark.parametrize(
    ("cell_v", "text", "is_marked"),
    [(3.9, "3.90 V", False), (3.52, "3.52 V", True), (4.7, "4.70 V", True)],
)
def test_a_voltage_outside_its_limit_is_marked(qapp: QApplication, cell_v: float, text: str, is_marked: bool) -> None:
    seen = SeenRecord(1, 0, b"", "", None, "")
    record = RECORD._replace(cell_voltage_v=cell_v)
    row = TriggerRow(seen, record, is_new=False, is_on_module=True, is_stored=False)
    column = COLUMNS[Column.CELL]
    assert column.text(row) == text
    assert column.picture is not None
    assert column.ink is not None
    assert (column.picture(row) is not None, column.ink(row) is not None) == (is_marked, is_marked)
