"""Table model of the recordings, with sorting and search."""

from enum import IntEnum
from typing import Any, Final

from PySide6.QtCore import QObject, QSortFilterProxyModel, Qt
from PySide6.QtGui import QColor

from app.recordings.entry_texts import remarks, size_text, told
from app.recordings.library import RecordingEntry
from app.text.durations import stopwatch
from app.text.i18n import tr
from protocol.translatable import marked
from ui.forms.rows_model import Index, RowsModel, aligned
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, current

SORT_ROLE: Final = Qt.ItemDataRole.UserRole
ENTRY_ROLE: Final = Qt.ItemDataRole.UserRole + 1


class Column(IntEnum):
    WHEN = 0
    MODULE = 1
    PORT = 2
    DURATION = 3
    SAMPLES = 4
    SIZE = 5
    KEPT = 6
    REMARKS = 7


HEADS: Final = (
    marked("When"),
    marked("Module"),
    marked("Port"),
    marked("Duration"),
    marked("Samples"),
    marked("Size"),
    marked("Kept"),
    marked("Remarks"),
)
RIGHT: Final = frozenset((Column.DURATION, Column.SAMPLES, Column.SIZE))


def cell_text(entry: RecordingEntry, column: Column) -> str:
    is_known = entry.trouble is None
    match column:
        case Column.WHEN:
            return f"{entry.started_at.astimezone():%Y-%m-%d %H:%M}"
        case Column.MODULE:
            return entry.module or "—"
        case Column.PORT:
            return entry.port.removeprefix("/dev/") or "—"
        case Column.DURATION:
            return stopwatch(entry.duration_s) if is_known else "—"
        case Column.SAMPLES:
            return f"{entry.sample_count:,}" if is_known else "—"
        case Column.SIZE:
            return size_text(entry.size_bytes)
        case Column.KEPT:
            return tr("kept") if entry.is_kept else ""
        case Column.REMARKS:
            return remarks(entry)


class RecordingsModel(RowsModel[RecordingEntry]):
    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(HEADS, lambda entry: entry.folder, parent=parent)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if orientation is Qt.Orientation.Horizontal and role == Qt.ItemDataRole.TextAlignmentRole:
            return aligned(is_right=section in RIGHT)
        return super().headerData(section, orientation, role)

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if not index.isValid() or index.row() >= len(self.rows):
            return None
        entry, column = self.rows[index.row()], Column(index.column())
        match role:
            case Qt.ItemDataRole.DisplayRole:
                return cell_text(entry, column)
            case Qt.ItemDataRole.DecorationRole:
                return _decoration(entry, column)
            case Qt.ItemDataRole.ForegroundRole if entry.trouble is not None:
                return QColor(current().attention.ink)
            case Qt.ItemDataRole.TextAlignmentRole:
                return aligned(is_right=column in RIGHT)
            case Qt.ItemDataRole.ToolTipRole | Qt.ItemDataRole.AccessibleDescriptionRole:
                return told(entry)
            case _ if role == SORT_ROLE:
                return sort_key(entry, column)
            case _ if role == ENTRY_ROLE:
                return entry
        return None


def sort_key(entry: RecordingEntry, column: Column) -> float | str:
    match column:
        case Column.WHEN:
            return entry.started_at.timestamp()
        case Column.DURATION:
            return entry.duration_s
        case Column.SAMPLES:
            return float(entry.sample_count)
        case Column.SIZE:
            return float(entry.size_bytes)
        case _:
            return cell_text(entry, column).casefold()


def _decoration(entry: RecordingEntry, column: Column) -> Any:
    match column:
        case Column.KEPT if entry.is_kept:
            return icon(Icon.BOOKMARK)
        case Column.REMARKS if entry.trouble is not None or entry.was_cut_off:
            return icon(Icon.WARNING, Meaning.ATTENTION)
        case Column.REMARKS if entry.is_running:
            return icon(Icon.RECORD)
        case Column.REMARKS if entry.is_simulated:
            return icon(Icon.SIMULATOR)
    return None


class RecordingsFilter(QSortFilterProxyModel):
    """By words, which must all be found somewhere in the row."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.setSortRole(SORT_ROLE)
        self._words: tuple[str, ...] = ()

    def search(self, text: str) -> None:
        self.beginFilterChange()
        self._words = tuple(text.casefold().split())
        self.endFilterChange(QSortFilterProxyModel.Direction.Rows)

    def filterAcceptsRow(self, source_row: int, _source_parent: Index) -> bool:
        model = self.sourceModel()
        if not isinstance(model, RecordingsModel):
            return False
        entry = model.rows[source_row]
        text = " ".join(cell_text(entry, column) for column in Column).casefold()
        return all(word in text for word in self._words)

    def entry_at(self, row: int) -> RecordingEntry:
        found = self.index(row, 0).data(ENTRY_ROLE)
        if not isinstance(found, RecordingEntry):
            raise IndexError(row)
        return found
