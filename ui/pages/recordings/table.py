"""Table view of the recordings."""

from typing import Final

from PySide6.QtCore import QModelIndex, QRectF, Qt, Signal
from PySide6.QtGui import QFontMetrics, QKeyEvent, QPainter
from PySide6.QtWidgets import QHeaderView, QStyledItemDelegate, QStyleOptionViewItem, QTableView, QWidget

from app.recordings.library import RecordingEntry
from app.text.i18n import tr
from ui.forms.table_kit import ROW_ROLE, Index, RowsFilter, list_rows
from ui.pages.recordings.model import COLUMNS, Column
from ui.pages.recordings.outlines import Outlines, draw_outline
from ui.style.theme import Size, Space, current, font, scaled
from ui.widgets.naming import named

ROW_PX: Final = 44
_OUTLINE_PX: Final = 112
_BESIDE: Final = (Column.PORT, Column.SAMPLES, Column.SIZE, Column.REMARKS)
"""What the detail beside the table says; the rows are searched with it."""
_PAD_PX: Final = 5
_FRAME_PX: Final = 8
"""What the style takes at both sides of a cell."""
_ICON_PX: Final = 24


class OutlineDelegate(QStyledItemDelegate):
    """Paints the small picture of a recording's tilt."""

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


class RecordingsTable(QTableView):
    opened = Signal()
    """A person wants to look at what is chosen."""
    delete_wanted = Signal()

    def __init__(self, model: RowsFilter[RecordingEntry], outlines: Outlines, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        named(self, "recordings_table")
        self._filter = model
        self.setModel(model)
        self.setSortingEnabled(True)
        self.sortByColumn(Column.WHEN, Qt.SortOrder.DescendingOrder)
        self.setAlternatingRowColors(True)
        list_rows(self, row_px=ROW_PX)
        self.setItemDelegateForColumn(Column.TILT, OutlineDelegate(outlines, self))
        for column in _BESIDE:
            self.setColumnHidden(column, True)
        outlines.changed.connect(self.viewport().update)
        columns = self.horizontalHeader()
        columns.setSectionResizeMode(Column.MODULE, QHeaderView.ResizeMode.Stretch)
        columns.setMinimumSectionSize(56)
        # Level with the heads, which the window's style sheet sets in by as much.
        self.doubleClicked.connect(self._open)
        self.measure()

    def measure(self) -> None:
        """Columns as wide as their widest usual text, after a change of language, font or theme."""
        body, strong = QFontMetrics(font(Size.BODY)), QFontMetrics(font(Size.SMALL, is_bold=True))
        texts = {
            Column.WHEN: "0000-00-00 00:00",
            Column.DURATION: "00:00:00",
            Column.KEPT: tr("pinned"),
        }
        self.setColumnWidth(Column.TILT, _OUTLINE_PX)
        self.horizontalHeader().setMinimumSectionSize(
            max(56, strong.horizontalAdvance(tr(COLUMNS[Column.MODULE].title)) + Space.XL)
        )
        for column, text in texts.items():
            # The sorted one has an arrow beside its head.
            head = strong.horizontalAdvance(tr(COLUMNS[column].title)) + Space.XL + 2
            extra = _ICON_PX if column in (Column.KEPT, Column.WHEN) else 0
            self.setColumnWidth(
                column, max(body.horizontalAdvance(text) + extra + 2 * scaled(_PAD_PX) + _FRAME_PX, head)
            )

    def chosen(self) -> tuple[RecordingEntry, ...]:
        """In the order in which they stand."""
        rows = sorted(index.row() for index in self.selectionModel().selectedRows())
        return tuple(self._filter.row_at(row) for row in rows)

    def choose(self, entries: tuple[RecordingEntry, ...]) -> None:
        """Select these again where they are still there; the table was filled again."""
        wanted = {one.folder for one in entries}
        self.clearSelection()
        for row in range(self._filter.rowCount()):
            if self._filter.row_at(row).folder in wanted:
                self.selectionModel().select(
                    self._filter.index(row, 0),
                    self.selectionModel().SelectionFlag.Select | self.selectionModel().SelectionFlag.Rows,
                )

    def _open(self, _index: QModelIndex) -> None:
        self.opened.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.opened.emit()
        elif event.key() == Qt.Key.Key_Delete:
            self.delete_wanted.emit()
        else:
            super().keyPressEvent(event)
