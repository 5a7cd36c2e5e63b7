"""Table model whose rows are replaced as a whole; keeps the selection."""

from collections.abc import Callable, Sequence
from typing import Any, Generic, TypeVar

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QObject, QPersistentModelIndex, Qt

from app.text.i18n import tr

Index = QModelIndex | QPersistentModelIndex
Row = TypeVar("Row")


class RowsModel(QAbstractTableModel, Generic[Row]):
    """`heads`: English, marked. `identify`: what stays the same of a row while its figures change."""

    def __init__(
        self, heads: Sequence[str], identify: Callable[[Row], object], *, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self.rows: tuple[Row, ...] = ()
        self._heads, self._identify = heads, identify

    def show_rows(self, rows: tuple[Row, ...]) -> None:
        """Only what is different is told: the same rows with other figures keep what is selected."""
        if rows == self.rows:
            return
        if [self._identify(row) for row in rows] == [self._identify(row) for row in self.rows]:
            self.rows = rows
            self._tell_of_figures()
            return
        self.beginResetModel()
        self.rows = rows
        self.endResetModel()

    def retranslate(self) -> None:
        self.headerDataChanged.emit(Qt.Orientation.Horizontal, 0, len(self._heads) - 1)
        if self.rows:
            self._tell_of_figures()

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008  Qt's own signature
        return 0 if parent.isValid() else len(self.rows)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008
        return 0 if parent.isValid() else len(self._heads)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if orientation is Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return tr(self._heads[section])
        return None

    def _tell_of_figures(self) -> None:
        self.dataChanged.emit(self.index(0, 0), self.index(len(self.rows) - 1, len(self._heads) - 1))


def aligned(*, is_right: bool) -> int:
    """For the role of that name."""
    side = Qt.AlignmentFlag.AlignRight if is_right else Qt.AlignmentFlag.AlignLeft
    return int(side | Qt.AlignmentFlag.AlignVCenter)
