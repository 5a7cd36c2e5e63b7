"""Table model of the trigger records, with sorting, search and copy."""

from collections.abc import Iterable
from enum import Enum, IntEnum
from typing import Any, Final

from PySide6.QtCore import QObject, QSortFilterProxyModel, Qt
from PySide6.QtGui import QColor

from app.limits.out_of_limits import record_outside
from app.text.durations import stopwatch
from app.text.i18n import tr
from app.trigger_records.fields import SOURCE_WORDS
from app.trigger_records.history import JUDGEMENT_WORDS, sentence
from protocol.translatable import marked
from ui.forms.rows_model import Index, RowsModel, aligned
from ui.pages.triggers.controller import TriggerRow
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, current

SORT_ROLE: Final = Qt.ItemDataRole.UserRole
SENTENCE_ROLE: Final = Qt.ItemDataRole.UserRole + 1
ROW_ROLE: Final = Qt.ItemDataRole.UserRole + 2


class Column(IntEnum):
    WHEN = 0
    WHY = 1
    SETTINGS = 2
    LINK = 3
    CHARGE = 4
    LIGHT = 5
    CELL = 6
    JUDGED = 7


HEADS: Final = (
    marked("When"),
    marked("Why"),
    marked("Settings"),
    marked("Link"),
    marked("Charge"),
    marked("Light"),
    marked("Cell"),
    marked("Judged"),
)
RIGHT: Final = frozenset((Column.LIGHT,))


class Show(Enum):
    """Which records are shown; the value is English, translatable."""

    ALL = marked("All records")
    ON_MODULE = marked("On the module now")
    NEW = marked("New since the last visit")
    IMPLAUSIBLE = marked("Implausible")
    UNJUDGED = marked("Not judged yet")


class TriggersModel(RowsModel[TriggerRow]):
    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(HEADS, lambda row: row.seen.id, parent=parent)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        is_settings = orientation is Qt.Orientation.Horizontal and section == Column.SETTINGS
        if is_settings and role == Qt.ItemDataRole.ToolTipRole:
            return tr("The settings at that moment: angle, acceleration and time")
        return super().headerData(section, orientation, role)

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if not index.isValid() or index.row() >= len(self.rows):
            return None
        row, column = self.rows[index.row()], Column(index.column())
        match role:
            case Qt.ItemDataRole.DisplayRole:
                return cell_text(row, column)
            case Qt.ItemDataRole.DecorationRole:
                return _decoration(row, column)
            case Qt.ItemDataRole.ForegroundRole if column is Column.CELL and row.record.implausible:
                return QColor(current().attention.ink)
            case Qt.ItemDataRole.TextAlignmentRole:
                return aligned(is_right=column in RIGHT)
            case Qt.ItemDataRole.ToolTipRole | Qt.ItemDataRole.AccessibleDescriptionRole:
                return told(row)
            case _ if role == SENTENCE_ROLE:
                return told(row)
            case _ if role == SORT_ROLE:
                return sort_key(row, column)
            case _ if role == ROW_ROLE:
                return row
        return None


def told(row: TriggerRow) -> str:
    """The record as one sentence, whether it is new, and what a person noted of it."""
    text = sentence(row.record).in_words()
    if row.is_seen_once:
        text = tr("Seen once, not confirmed: {sentence}", sentence=text)
    if row.is_new:
        text = tr("NEW: {sentence}", sentence=text)
    return tr("{sentence} — note: {note}", sentence=text, note=row.seen.note) if row.seen.note else text


def cell_text(row: TriggerRow, column: Column) -> str:
    record = row.record
    match column:
        case Column.WHEN:
            return tr("boot {boot} · {uptime}", boot=record.boot_count, uptime=stopwatch(record.uptime_s))
        case Column.WHY:
            return sources_in_words(record.sources)
        case Column.SETTINGS:
            return (
                f"{record.attitude_threshold_deg}° {record.freefall_acceleration_g:.1f} g "
                f"{record.freefall_time_s:.2f} s"
            )
        case Column.LINK:
            return tr("connected") if record.serial_connected else tr("no")
        case Column.CHARGE:
            return tr("charging") if record.charging else tr("no")
        case Column.LIGHT:
            return f"{record.light_v:.1f} V"
        case Column.CELL:
            volts = f"{record.cell_voltage_v:.2f} V"
            outside = record_outside(record)
            if outside is not None:
                return f"{volts} ({tr(outside.fault.value)})"
            return tr("{voltage} implausible", voltage=volts) if record.implausible else volts
        case Column.JUDGED if row.is_seen_once:
            return tr("seen once")
        case Column.JUDGED:
            return "—" if row.seen.judgement is None else tr(JUDGEMENT_WORDS[row.seen.judgement])


def sources_in_words(sources: tuple[str, ...]) -> str:
    """Combined ones with a plus; one that the vendor does not name by its bit."""
    words = []
    for name in sources:
        text = SOURCE_WORDS.get(name)
        words.append(tr("unnamed ({bit})", bit=name) if text is None else tr(text))
    return " + ".join(words) or tr("no cause stated")


def sort_key(row: TriggerRow, column: Column) -> float | str:
    record = row.record
    match column:
        case Column.WHEN:
            return float(row.seen.place)
        case Column.SETTINGS:
            return float(record.attitude_threshold_deg)
        case Column.LIGHT:
            return record.light_v
        case Column.CELL:
            return record.cell_voltage_v
        case _:
            return cell_text(row, column)


def _decoration(row: TriggerRow, column: Column) -> Any:
    match column:
        case Column.WHEN if row.is_seen_once:
            return icon(Icon.UNKNOWN, Meaning.ATTENTION)
        case Column.WHEN if row.is_new:
            return icon(Icon.INFORMATION, Meaning.INFORMATION)
        case Column.CELL if row.record.implausible or record_outside(row.record) is not None:
            return icon(Icon.WARNING, Meaning.ATTENTION)
    return None


class TriggersFilter(QSortFilterProxyModel):
    """By a choice and by words, which must all be found somewhere in the row."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.setSortRole(SORT_ROLE)
        self._show, self._words = Show.ALL, ()  # type: tuple[Show, tuple[str, ...]]

    def use(self, show: Show, text: str) -> None:
        self.beginFilterChange()
        self._show, self._words = show, tuple(text.casefold().split())
        self.endFilterChange(QSortFilterProxyModel.Direction.Rows)

    def filterAcceptsRow(self, source_row: int, _source_parent: Index) -> bool:
        model = self.sourceModel()
        if not isinstance(model, TriggersModel):
            return False
        row = model.rows[source_row]
        if not _is_chosen(row, self._show):
            return False
        text = " ".join([told(row), *(cell_text(row, column) for column in Column)]).casefold()
        return all(word in text for word in self._words)

    def shown(self) -> tuple[TriggerRow, ...]:
        """In the order in which they stand on the page."""
        return tuple(self.index(row, 0).data(ROW_ROLE) for row in range(self.rowCount()))


def _is_chosen(row: TriggerRow, show: Show) -> bool:
    match show:
        case Show.ALL:
            return True
        case Show.ON_MODULE:
            return row.is_on_module
        case Show.NEW:
            return row.is_new
        case Show.IMPLAUSIBLE:
            return bool(row.record.implausible)
        case Show.UNJUDGED:
            return row.seen.judgement is None


def as_text(rows: Iterable[TriggerRow]) -> str:
    """Tab-separated, with a head, the sentence at the end."""
    lines = ["\t".join([*(tr(head) for head in HEADS), tr("Told"), tr("Raw bytes")])]
    for row in rows:
        cells = [cell_text(row, column) for column in Column]
        lines.append("\t".join([*cells, told(row).replace("\t", " "), row.record.raw.hex(" ").upper()]))
    return "\n".join(lines) + "\n"


def csv_name(module: str) -> str:
    """A file name, whatever the module is called."""
    safe = "".join(one if one.isalnum() or one in "-_" else "_" for one in module[:40])
    return f"dps-s triggers {safe or 'module'}.csv"
