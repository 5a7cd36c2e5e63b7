"""Table view of the recordings."""

from typing import Final

from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainter
from PySide6.QtWidgets import QStyledItemDelegate, QStyleOptionViewItem, QTableView

from app.recordings.library import RecordingEntry
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import ROW_ROLE, Index, RowsFilter
from ui.pages.recordings.model import Column
from ui.pages.recordings.outlines import Outlines, draw_outline
from ui.style.theme import current

ROW_PX: Final = 44
_OUTLINE_PX: Final = 88
_BESIDE: Final = (Column.PORT, Column.SAMPLES, Column.SIZE, Column.REMARKS)
"""Hidden columns, shown in the details; rows are searched with them."""
_FRAME_PX: Final = 8
"""Padding of the style at both sides of a cell."""


class OutlineDelegate(QStyledItemDelegate):
    """Paints the outline of a recording."""

    def __init__(self, outlines: Outlines, parent: QTableView) -> None:
        super().__init__(parent)
        self._outlines = outlines

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        super().paint(painter, option, index)
        entry = index.data(ROW_ROLE)
        if isinstance(entry, RecordingEntry):
            painter.save()
            box = QRectF(option.rect).adjusted(_FRAME_PX, 7, -_FRAME_PX, -7)
            draw_outline(painter, box, self._outlines.of(entry), current())
            painter.restore()


class PinDelegate(QStyledItemDelegate):
    """Paints the icon only, since the header says the word; the model's text is for search and screen readers."""

    def initStyleOption(self, option: QStyleOptionViewItem, index: Index) -> None:
        super().initStyleOption(option, index)
        option.text = ""


class RecordingsTable(RowsTable[RecordingEntry]):
    def __init__(self, model: RowsFilter[RecordingEntry], outlines: Outlines) -> None:
        super().__init__("recordings_table", model, row_px=ROW_PX, sorted_by=Column.WHEN, stretched=Column.MODULE,
                         hidden=_BESIDE, spare=Column.DURATION)  # fmt: skip
        self.setAlternatingRowColors(True)
        self.setItemDelegateForColumn(Column.TILT, OutlineDelegate(outlines, self))
        self.setItemDelegateForColumn(Column.PINNED, PinDelegate(self))
        outlines.changed.connect(self.viewport().update)
        self.measure()

    def measure(self) -> None:
        self.fit_columns(
            {
                Column.WHEN: "0000-00-00 00:00", Column.MODULE: "M-00", Column.DURATION: "00:00:00",
                Column.PINNED: "",
            },
            with_icon=(Column.PINNED, Column.WHEN), fixed_px={Column.TILT: _OUTLINE_PX},
        )  # fmt: skip
