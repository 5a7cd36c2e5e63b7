"""Tables of the archive: every module today, and the history of one."""

from collections.abc import Callable, Sequence
from datetime import datetime
from typing import Final, Generic, TypeVar

from PySide6.QtWidgets import QHeaderView, QTableView, QWidget

from app.archive.fleet_state import ModuleToday
from app.archive.module_history import HistoryEvent
from app.stations.station import KEY_BYTES, decoded, fingerprint_of
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import join_sentences
from protocol.translatable import marked
from ui.forms.table_kit import RowsFilter, RowsModel, TableColumn, list_rows
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning
from ui.widgets.controls import named

Row = TypeVar("Row")
_ROW_PX: Final = 26


class ArchiveTable(Generic[Row]):
    """A table view with its model."""

    def __init__(
        self,
        parent: QWidget,
        name: str,
        columns: Sequence[TableColumn[Row]],
        identify: Callable[[Row], object],
        tell: Callable[[Row], str],
    ) -> None:
        self.model: RowsModel[Row] = RowsModel(columns, identify, tell, parent, aligns_heads=True)
        self.rows: RowsFilter[Row] = RowsFilter(self.model, parent)
        self.view = named(QTableView(), name)
        self.view.setModel(self.rows)
        list_rows(self.view, row_px=_ROW_PX)
        self.view.setSelectionMode(QTableView.SelectionMode.SingleSelection)
        head = self.view.horizontalHeader()
        head.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        head.setStretchLastSection(True)

    def chosen(self) -> Row | None:
        """None if no row is selected."""
        rows = self.view.selectionModel().selectedRows()
        return self.rows.row_at(rows[0].row()) if rows else None


def modules_table(parent: QWidget) -> ArchiveTable[ModuleToday]:
    return ArchiveTable(parent, "archive_modules", _MODULE_COLUMNS, lambda row: row.module.members, _accessible_text)


def history_table(parent: QWidget) -> ArchiveTable[HistoryEvent]:
    return ArchiveTable(
        parent, "archive_life", _HISTORY_COLUMNS, lambda row: row.fact.id, lambda row: row.text.translated()
    )


def short_station(public: str) -> str:
    """The beginning of its fingerprint."""
    return fingerprint_of(decoded(public, KEY_BYTES) or b"")[:9]


def _verdict(row: ModuleToday) -> str:
    return tr("none") if row.last_check is None else row.last_check.words.translated()


def _is_no_go(row: ModuleToday) -> bool:
    return row.last_check is not None and not row.last_check.holds


def _due(row: ModuleToday) -> str:
    return join_sentences(one.text.translated() for one in row.due)


def _accessible_text(row: ModuleToday) -> str:
    return f"{clean(row.module.name)}: " + (_due(row) or tr("nothing due"))


def _local(at: str) -> str:
    return f"{datetime.fromisoformat(at).astimezone():%Y-%m-%d %H:%M}"


_MODULE_COLUMNS: Final = (
    TableColumn[ModuleToday](marked("Module"), lambda row: clean(row.module.name)),
    TableColumn[ModuleToday](marked("Stations"), lambda row: str(len({one.station for one in row.module.members}))),
    TableColumn[ModuleToday](marked("Last check"), lambda row: _local(row.last_check.at) if row.last_check else ""),
    TableColumn[ModuleToday](
        marked("Verdict"), _verdict, ink=lambda row: Meaning.DANGER if _is_no_go(row) else None,
        picture=lambda row: icon(Icon.CROSS, Meaning.DANGER) if _is_no_go(row) else None,
    ),
    TableColumn[ModuleToday](marked("Trigger records"), lambda row: str(row.trigger_records)),
    TableColumn[ModuleToday](
        marked("Due"), _due,
        ink=lambda row: Meaning.ATTENTION if row.due else None,
        picture=lambda row: icon(Icon.WARNING, Meaning.ATTENTION) if row.due else None,
    ),
)  # fmt: skip
_HISTORY_COLUMNS: Final = (
    TableColumn[HistoryEvent](marked("Time"), lambda row: _local(row.fact.made_at)),
    TableColumn[HistoryEvent](marked("Station"), lambda row: short_station(row.fact.station)),
    TableColumn[HistoryEvent](marked("Record"), lambda row: row.text.translated()),
)
