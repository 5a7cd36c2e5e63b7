"""The table kit: columns, a model replaced as a whole, a filter that sorts, and a table that opens its rows."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any, Final, Generic, TypeVar

from PySide6.QtCore import (
    QAbstractTableModel,
    QItemSelection,
    QItemSelectionModel,
    QModelIndex,
    QObject,
    QPersistentModelIndex,
    QSize,
    QSortFilterProxyModel,
    Qt,
    QTimer,
    Signal,
)
from PySide6.QtGui import QColor, QFontMetrics, QIcon, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QLineEdit, QStackedWidget, QTableView, QWidget

from app.text.i18n import tr
from ui.style.icons import Icon
from ui.style.theme import IconSize, Meaning, Size, Space, current, font, scaled
from ui.widgets.controls import EmptyState, Shortcut, name_key, named, stacked

Index = QModelIndex | QPersistentModelIndex
Row = TypeVar("Row")
_SORT_ROLE: Final = Qt.ItemDataRole.UserRole
_ROW_ROLE: Final = Qt.ItemDataRole.UserRole + 1
# Padding at each side of a cell, in the style sheet; frame of the style, both sides together.
_PAD_PX: Final = 5
_FRAME_PX: Final = 8
_SEARCH_PX: Final = 140
_MEASURED_ROWS: Final = 100


@dataclass(frozen=True)
class TableColumn(Generic[Row]):
    """`title` of the header is English, marked. Without `sort_key` rows are sorted by their text."""

    title: str
    text: Callable[[Row], str]
    sort_key: Callable[[Row], float | str] | None = None
    is_right: bool = False
    picture: Callable[[Row], QIcon | None] | None = None
    ink: Callable[[Row], Meaning | None] = lambda _row: None
    # The text that has to fit, in the language in use; without one the column is as wide as its contents.
    widest: Callable[[], str] | None = None
    # Takes what room remains, beside others that do.
    stretches: bool = False
    # Hidden where there is no room for it.
    is_spare: bool = False

    @property
    def alignment(self) -> int:
        side = Qt.AlignmentFlag.AlignRight if self.is_right else Qt.AlignmentFlag.AlignLeft
        return int(side | Qt.AlignmentFlag.AlignVCenter)


class RowsModel(QAbstractTableModel, Generic[Row]):
    """`identify` returns what identifies a row while its figures change, `tell` the row as a sentence."""

    def __init__(
        self,
        columns: Sequence[TableColumn[Row]],
        identify: Callable[[Row], object],
        tell: Callable[[Row], str],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.rows: Sequence[Row] = ()
        self.columns, self.tell = columns, tell
        self.identify = identify

    def show_rows(self, rows: tuple[Row, ...]) -> None:
        """Replaces the rows."""
        if rows == self.rows:
            return
        if [self.identify(row) for row in rows] == [self.identify(row) for row in self.rows]:
            changed = [place for place, row in enumerate(rows) if row != self.rows[place]]
            self.rows = rows
            # From the first to the last: of a long list, one row is not sorted again with all others.
            self.dataChanged.emit(self.index(changed[0], 0), self.index(changed[-1], len(self.columns) - 1))
            return
        self.beginResetModel()
        self.rows = rows
        self.endResetModel()

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008  Qt's own signature
        return 0 if parent.isValid() else len(self.rows)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008
        return 0 if parent.isValid() else len(self.columns)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if orientation is not Qt.Orientation.Horizontal:
            return None
        if role == Qt.ItemDataRole.DisplayRole:
            return tr(self.columns[section].title)
        return self.columns[section].alignment if role == Qt.ItemDataRole.TextAlignmentRole else None

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if not index.isValid() or index.row() >= len(self.rows):
            return None
        row, column = self.rows[index.row()], self.columns[index.column()]
        match role:
            case Qt.ItemDataRole.DisplayRole:
                return column.text(row)
            case Qt.ItemDataRole.DecorationRole:
                return None if column.picture is None else column.picture(row)
            case Qt.ItemDataRole.ForegroundRole:
                meaning = column.ink(row)
                return None if meaning is None else QColor(current().ink(meaning))
            case Qt.ItemDataRole.TextAlignmentRole:
                return column.alignment
            case Qt.ItemDataRole.ToolTipRole | Qt.ItemDataRole.AccessibleDescriptionRole:
                return self.tell(row)
            case _ if role == _SORT_ROLE:
                return column.text(row).casefold() if column.sort_key is None else column.sort_key(row)
            case _ if role == _ROW_ROLE:
                return row
        return None


class RowsFilter(QSortFilterProxyModel, Generic[Row]):
    """Shows the rows that contain all searched words, in a cell or in their sentence, sorted by a column."""

    def __init__(self, model: RowsModel[Row], parent: QObject) -> None:
        super().__init__(parent)
        self._model = model
        self._words: tuple[str, ...] = ()
        self.setSortRole(_SORT_ROLE)
        self.setSourceModel(model)

    def use(self, text: str) -> None:
        self.beginFilterChange()
        self._words = tuple(text.casefold().split())
        self.endFilterChange(QSortFilterProxyModel.Direction.Rows)

    def filterAcceptsRow(self, source_row: int, _source_parent: Index) -> bool:
        row = self._model.rows[source_row]
        if not self._words:
            return True
        text = " ".join((*(column.text(row) for column in self._model.columns), self._model.tell(row))).casefold()
        return all(word in text for word in self._words)

    def row_at(self, place: int) -> Row:
        row: Row = self.index(place, 0).data(_ROW_ROLE)
        return row

    def shown(self) -> tuple[Row, ...]:
        return tuple(self.row_at(place) for place in range(self.rowCount()))


def select_row(table: QTableView, row: int) -> None:
    """Selects this row alone. `QTableView.selectRow` adds or removes it while a person holds Shift or Ctrl."""
    flag = QItemSelectionModel.SelectionFlag
    table.selectionModel().setCurrentIndex(table.model().index(row, 0), flag.ClearAndSelect | flag.Rows)


def list_rows(table: QTableView, *, row_px: int) -> None:
    """Sets up `table` as a list: whole rows of one height without numbers, higher where the
    text is; Tab leaves the table."""
    table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
    table.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
    table.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
    table.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
    table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
    table.setShowGrid(False)
    table.setWordWrap(False)
    table.setTabKeyNavigation(False)
    rows = table.verticalHeader()
    rows.hide()
    rows.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
    rows.setDefaultSectionSize(max(row_px, QFontMetrics(font()).height() + Space.S))
    table.horizontalHeader().setHighlightSections(False)
    table.horizontalHeader().setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
    table.setIconSize(QSize(scaled(IconSize.TEXT), scaled(IconSize.TEXT)))


def wrap_rows(table: QTableView) -> None:
    """Lets texts wrap. Only the rows in sight are measured: for thousands Qt would take seconds, and nobody could press
    LOCK meanwhile."""
    rows, bar, timer = table.verticalHeader(), table.verticalScrollBar(), QTimer(table, singleShot=True, interval=0)

    def fit() -> None:
        first, last = table.rowAt(0), table.rowAt(table.viewport().height() - 1)
        if last < 0:  # they end above it
            last = table.model().rowCount() - 1
        for row in range(max(first, 0), last + 1):
            table.resizeRowToContents(row)

    table.setWordWrap(True)
    rows.setMinimumSectionSize(rows.defaultSectionSize())
    timer.timeout.connect(fit)
    model, columns = table.model(), table.horizontalHeader()
    for changed in (bar.valueChanged, bar.rangeChanged, columns.sectionResized, model.modelReset, model.dataChanged):
        changed.connect(lambda *_: timer.start())


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
        named(self, name, says=says)
        self._widths: list[int] = []

        def as_shown(row: Row) -> str:
            return ", ".join(column.text(row) for column in columns)

        self.source: RowsModel[Row] = RowsModel(columns, identify, tell or as_shown, self)
        self.filter: RowsFilter[Row] = RowsFilter(self.source, self)
        self.setModel(self.filter)
        list_rows(self, row_px=row_px)
        if is_single:
            self.setSelectionMode(QTableView.SelectionMode.SingleSelection)
        self.doubleClicked.connect(lambda _index: self.opened.emit())
        # Of longer lists Qt would measure a thousand rows, several times a change.
        self.horizontalHeader().setResizeContentsPrecision(_MEASURED_ROWS)
        modes = QHeaderView.ResizeMode
        body, heads = QFontMetrics(font(Size.BODY)), QFontMetrics(font(Size.SMALL, is_bold=True))
        for place, column in enumerate(columns):
            mode = modes.ResizeToContents if column.widest is None else modes.Interactive
            self.horizontalHeader().setSectionResizeMode(place, modes.Stretch if column.stretches else mode)
            # As wide as the text that has to fit, and at least as the header with its arrow.
            width = heads.horizontalAdvance(tr(column.title)) + scaled(Space.XL) + 2
            if column.widest is not None:
                icon_px = 0 if column.picture is None else scaled(IconSize.BUTTON)
                text_px = body.horizontalAdvance(column.widest())
                width = max(width, text_px + icon_px + 2 * scaled(_PAD_PX) + _FRAME_PX)
            self._widths.append(width)
            self.setColumnWidth(place, width)
        if sorted_by is not None:
            self.setSortingEnabled(True)
            self.sortByColumn(sorted_by, Qt.SortOrder.DescendingOrder)

    def show_rows(self, rows: Sequence[Row]) -> None:
        """What is chosen stays chosen, also among other rows."""
        identify = self.source.identify
        chosen = {identify(row) for row in self.chosen()}
        self.source.show_rows(tuple(rows))
        if chosen and not self.selectionModel().hasSelection():
            self.choose(lambda row: identify(row) in chosen)
        self._hide_spare()

    def chosen(self) -> tuple[Row, ...]:
        """The selected rows in the order shown."""
        rows = sorted(index.row() for index in self.selectionModel().selectedRows())
        return tuple(self.filter.row_at(row) for row in rows)

    def choose(self, is_wanted: Callable[[Row], bool]) -> None:
        """At once: chosen one by one, a thousand rows took half a minute."""
        wanted = [row for row in range(self.filter.rowCount()) if is_wanted(self.filter.row_at(row))]
        selection = QItemSelection()
        for _, together in groupby(enumerate(wanted), lambda pair: pair[1] - pair[0]):
            rows = [row for _, row in together]
            selection.select(self.filter.index(rows[0], 0), self.filter.index(rows[-1], 0))
        flag = QItemSelectionModel.SelectionFlag
        self.selectionModel().select(selection, flag.ClearAndSelect | flag.Rows)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._hide_spare()

    def _hide_spare(self) -> None:
        """Hides the last of the columns that are spare while there is no room for all."""
        # Whether it scrolls or not, so that lists of one width have the same columns.
        room_px = self.width() - 2 * self.frameWidth() - self.verticalScrollBar().sizeHint().width()
        widths = [
            width if column.widest is not None else max(width, self.sizeHintForColumn(place))
            for place, (column, width) in enumerate(zip(self.source.columns, self._widths, strict=True))
        ]
        needed_px = sum(widths)
        for place, column in reversed(list(enumerate(self.source.columns))):
            if column.is_spare:
                has_room = needed_px <= room_px
                self.setColumnHidden(place, not has_room)
                needed_px -= 0 if has_room else widths[place]

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
        self.search = named(QLineEdit(), f"{page}_search", says=tr("Search"))
        Shortcut(self.search, "Ctrl+F")
        name_key(self.search, "Ctrl+F")
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
