"""A table of whole rows, which are opened by double click or Enter; its search."""

from collections.abc import Callable, Sequence
from typing import Any, Final, Generic

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QFontMetrics, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QHeaderView, QLineEdit, QStackedWidget, QTableView

from app.text.i18n import tr
from ui.forms.table_kit import Row, RowsFilter, RowsModel, TableColumn, list_rows
from ui.style.icons import Icon
from ui.style.theme import IconSize, Size, Space, font, scaled
from ui.widgets.controls import control
from ui.widgets.labels import EmptyState
from ui.widgets.layouts import stacked

_PAD_PX: Final = 5
"""Padding at each side of a cell, in the style sheet."""
_FRAME_PX: Final = 8
"""Frame of the style, both sides together."""
_SEARCH_PX: Final = 140


class RowsTable(QTableView, Generic[Row]):
    """Makes a table of its columns; `says` is its accessible name, the rest as in `RowsModel`; without `tell` a row is
    read as its cells. Sorted by a column, newest or largest first, or not at all."""

    opened = Signal()

    def __init__(
        self,
        name: str,
        says: str,
        columns: Sequence[TableColumn[Row]],
        identify: Callable[[Row], object],
        tell: Callable[[Row], str] | None = None,
        *,
        row_px: int,
        sorted_by: int | None = None,
        is_single: bool = False,
    ) -> None:
        super().__init__()
        control(self, name, says=says)
        self._widths: dict[int, int] = {}
        self.source: RowsModel[Row] = RowsModel(columns, identify, tell or self._as_shown, self)
        self.filter: RowsFilter[Row] = RowsFilter(self.source, self)
        self.setModel(self.filter)
        list_rows(self, row_px=row_px)
        if is_single:
            self.setSelectionMode(QTableView.SelectionMode.SingleSelection)
        self.doubleClicked.connect(lambda _index: self.opened.emit())
        modes = QHeaderView.ResizeMode
        for place, column in enumerate(columns):
            mode = modes.ResizeToContents if column.widest is None else modes.Interactive
            self.horizontalHeader().setSectionResizeMode(place, modes.Stretch if column.stretches else mode)
        self.measure()
        if sorted_by is not None:
            self.setSortingEnabled(True)
            self.sortByColumn(sorted_by, Qt.SortOrder.DescendingOrder)

    def _as_shown(self, row: Row) -> str:
        return ", ".join(column.text(row) for column in self.source.columns)

    def show_rows(self, rows: Sequence[Row]) -> None:
        self.source.show_rows(tuple(rows))

    def chosen(self) -> tuple[Row, ...]:
        """The selected rows in the order shown."""
        rows = sorted(index.row() for index in self.selectionModel().selectedRows())
        return tuple(self.filter.row_at(row) for row in rows)

    def choose(self, is_wanted: Callable[[Row], bool]) -> None:
        model = self.selectionModel()
        self.clearSelection()
        for row in range(self.filter.rowCount()):
            if is_wanted(self.filter.row_at(row)):
                model.select(self.filter.index(row, 0), model.SelectionFlag.Select | model.SelectionFlag.Rows)

    def measure(self) -> None:
        """Makes the columns as wide as the texts that have to fit, and at least as their headers with the arrow."""
        body, heads = QFontMetrics(font(Size.BODY)), QFontMetrics(font(Size.SMALL, is_bold=True))
        for place, column in enumerate(self.source.columns):
            width = heads.horizontalAdvance(tr(column.title)) + scaled(Space.XL) + 2
            if column.widest is not None:
                icon_px = 0 if column.picture is None else scaled(IconSize.BUTTON)
                text_px = body.horizontalAdvance(column.widest())
                width = max(width, text_px + icon_px + 2 * scaled(_PAD_PX) + _FRAME_PX)
            self._widths[place] = width
            self.setColumnWidth(place, width)
        self._hide_spare()

    def _hide_spare(self) -> None:
        """Hides the last of the columns that are spare while there is no room for all."""
        # Whether it scrolls or not, so that lists of one width have the same columns.
        room_px = self.width() - 2 * self.frameWidth() - self.verticalScrollBar().sizeHint().width()
        columns = list(enumerate(self.source.columns))
        needed_px = sum(self._widths[place] for place, _column in columns)
        for place, column in reversed(columns):
            if column.is_spare:
                has_room = needed_px <= room_px
                self.setColumnHidden(place, not has_room)
                if not has_room:
                    needed_px -= self._widths[place]

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._hide_spare()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.opened.emit()
        else:
            super().keyPressEvent(event)


class SearchedRows(QStackedWidget):
    """A table, or why it shows no rows; the page places `search`. `words`: title and text of `empty`, as there."""

    def __init__(self, page: str, table: RowsTable[Row], picture: Icon, *words: str) -> None:
        super().__init__()
        self._table: RowsTable[Any] = table
        self.search = control(QLineEdit(), f"{page}_search", says=tr("Search"), keys="Ctrl+F")
        self.search.setFixedWidth(_SEARCH_PX)
        self.search.setClearButtonEnabled(True)
        self.search.setPlaceholderText(tr("Search"))
        self.search.textChanged.connect(self._filter)
        self.empty = EmptyState(f"{page}_empty", picture, *words)
        self.no_match = EmptyState(f"{page}_no_match", picture, tr("No matches"))
        stacked(self, self.empty, table, self.no_match)

    def show_rows(self, rows: Sequence[object]) -> None:
        self._table.show_rows(rows)
        self._show_view()

    def _filter(self, text: str) -> None:
        self._table.filter.use(text)
        self._show_view()

    def _show_view(self) -> None:
        content = self._table if self._table.filter.rowCount() else self.no_match
        self.setCurrentWidget(content if self._table.source.rows else self.empty)
