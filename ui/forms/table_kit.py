"""Tables: column descriptions, a model whose rows are replaced as a whole, and a filter that also sorts."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final, Generic, TypeVar

from PySide6.QtCore import (
    QAbstractTableModel,
    QItemSelectionModel,
    QModelIndex,
    QObject,
    QPersistentModelIndex,
    QSize,
    QSortFilterProxyModel,
    Qt,
)
from PySide6.QtGui import QColor, QFontMetrics, QIcon
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView, QWidget

from app.text.i18n import tr
from ui.style.theme import IconSize, Meaning, Space, current, font, scaled

Index = QModelIndex | QPersistentModelIndex
Row = TypeVar("Row")
SORT_ROLE: Final = Qt.ItemDataRole.UserRole
ROW_ROLE: Final = Qt.ItemDataRole.UserRole + 1


@dataclass(frozen=True)
class TableColumn(Generic[Row]):
    """`title` of the header is English, marked. Without `sort_key` rows are sorted by their text."""

    title: str
    text: Callable[[Row], str]
    sort_key: Callable[[Row], float | str] | None = None
    is_right: bool = False
    picture: Callable[[Row], QIcon | None] | None = None
    ink: Callable[[Row], Meaning | None] = lambda _row: None
    widest: Callable[[], str] | None = None
    """The text that has to fit, in the language in use; without one the column is as wide as its contents."""
    stretches: bool = False
    """Takes what room remains, beside others that do."""
    is_spare: bool = False
    """Hidden where there is no room for it."""


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
        self._identify = identify

    def show_rows(self, rows: tuple[Row, ...]) -> None:
        """Replaces the rows; the same rows with other figures stay selected."""
        if rows == self.rows:
            return
        if [self._identify(row) for row in rows] == [self._identify(row) for row in self.rows]:
            self.rows = rows
            self._emit_data_changed()
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
        column = self.columns[section]
        match role:
            case Qt.ItemDataRole.DisplayRole:
                return tr(column.title)
            case Qt.ItemDataRole.TextAlignmentRole:
                return aligned(is_right=column.is_right)
        return None

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
                return aligned(is_right=column.is_right)
            case Qt.ItemDataRole.ToolTipRole | Qt.ItemDataRole.AccessibleDescriptionRole:
                return self.tell(row)
            case _ if role == SORT_ROLE:
                return column.text(row).casefold() if column.sort_key is None else column.sort_key(row)
            case _ if role == ROW_ROLE:
                return row
        return None

    def _emit_data_changed(self) -> None:
        self.dataChanged.emit(self.index(0, 0), self.index(len(self.rows) - 1, len(self.columns) - 1))


class RowsFilter(QSortFilterProxyModel, Generic[Row]):
    """Shows the rows that contain all searched words, in a cell or in their sentence, sorted by a column."""

    def __init__(self, model: RowsModel[Row], parent: QObject) -> None:
        super().__init__(parent)
        self._model = model
        self._words: tuple[str, ...] = ()
        self.setSortRole(SORT_ROLE)
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
        """The row shown at `place`."""
        row: Row = self.index(place, 0).data(ROW_ROLE)
        return row

    def shown(self) -> tuple[Row, ...]:
        """All rows shown, in their order."""
        return tuple(self.row_at(place) for place in range(self.rowCount()))


def aligned(*, is_right: bool) -> int:
    side = Qt.AlignmentFlag.AlignRight if is_right else Qt.AlignmentFlag.AlignLeft
    return int(side | Qt.AlignmentFlag.AlignVCenter)


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
