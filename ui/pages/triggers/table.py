"""Table view of the trigger records."""

from typing import Final

from PySide6.QtCore import Qt

from app.text.i18n import tr
from app.trigger_records.history import JUDGEMENT_WORDS
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import RowsFilter
from ui.pages.triggers.controller import TriggerRow
from ui.pages.triggers.model import Column

ROW_PX: Final = 36
_BESIDE: Final = (Column.LINK, Column.CHARGE, Column.LIGHT, Column.CELL)
"""Hidden columns, shown in the details; rows are searched, copied and exported with them."""


class TriggersTable(RowsTable[TriggerRow]):
    def __init__(self, model: RowsFilter[TriggerRow]) -> None:
        super().__init__("triggers_table", model, row_px=ROW_PX, sorted_by=Column.WHEN, stretched=Column.WHY,
                         hidden=_BESIDE, spare=Column.SETTINGS)  # fmt: skip
        self.horizontalHeader().setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        self.measure()

    def measure(self) -> None:
        self.fit_columns({
            Column.WHY: max(f"{tr('attitude')} + {tr('free fall')}", f"{tr('serial')} + PWM", key=len),
            Column.WHEN: tr("boot {boot} · {uptime}", boot=255, uptime="0:00:00"),
            Column.SETTINGS: "180° 2.5 g 2.55 s",
            Column.JUDGED: max(tr("seen once"), *map(tr, JUDGEMENT_WORDS.values()), key=len),
        }, with_icon=(Column.WHEN,))  # fmt: skip
