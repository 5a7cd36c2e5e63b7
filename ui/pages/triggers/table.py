"""Table view of the trigger records: when, why, the settings then, what a person said of it."""

from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtGui import QFontMetrics, QResizeEvent
from PySide6.QtWidgets import QHeaderView, QTableView, QWidget

from app.text.i18n import tr
from ui.forms.table_kit import RowsFilter, list_rows
from ui.pages.triggers.controller import TriggerRow
from ui.pages.triggers.model import COLUMNS, Column
from ui.style.theme import Size, Space, font
from ui.widgets.naming import named

ROW_PX: Final = 36
_BESIDE: Final = (Column.LINK, Column.CHARGE, Column.LIGHT, Column.CELL)
"""What the detail beside the table says; the rows are searched, copied and saved with it."""


class TriggersTable(QTableView):
    def __init__(self, model: RowsFilter[TriggerRow], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        named(self, "triggers_table")
        self._widths: dict[Column, int] = {}
        self.setModel(model)
        self.setSortingEnabled(True)
        self.sortByColumn(Column.WHEN, Qt.SortOrder.DescendingOrder)
        list_rows(self, row_px=ROW_PX)
        for column in _BESIDE:
            self.setColumnHidden(column, True)
        columns = self.horizontalHeader()
        columns.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        columns.setSectionResizeMode(Column.WHY, QHeaderView.ResizeMode.Stretch)  # cut before the list scrolls sideways
        self.measure()

    def measure(self) -> None:
        """Columns as wide as their widest usual text, after a change of language, font or theme."""
        metrics = QFontMetrics(font(Size.BODY))
        heads = QFontMetrics(font(Size.SMALL, is_bold=True))
        texts = {
            Column.WHY: max(f"{tr('attitude')} + {tr('free fall')}", f"{tr('serial')} + PWM", key=len),
            Column.WHEN: tr("boot {boot} · {uptime}", boot=255, uptime="0:00:00") + "  ",
            Column.SETTINGS: "180° 2.5 g 2.55 s",
            Column.JUDGED: tr("seen once"),
        }
        for column, text in texts.items():
            head = heads.horizontalAdvance(tr(COLUMNS[column].title)) + Space.XL
            self._widths[column] = max(metrics.horizontalAdvance(text) + Space.XL, head)
            self.setColumnWidth(column, self._widths[column])
        self._fit()
        self.viewport().update()

    def _fit(self) -> None:
        """Where not all has room, the cause stays whole; the settings stand in the detail, too."""
        self.setColumnHidden(Column.SETTINGS, sum(self._widths.values()) > self.viewport().width())
        self.setColumnWidth(Column.SETTINGS, self._widths[Column.SETTINGS])

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self._widths:
            self._fit()
