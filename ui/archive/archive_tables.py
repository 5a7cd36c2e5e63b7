"""Tables of the archive: every module today, and the history of one."""

from datetime import datetime
from typing import Final

from app.archive.fleet_state import ModuleToday
from app.archive.module_history import HistoryEvent
from app.stations.station import shown_station
from app.text.i18n import tr
from app.text.messages import clean
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import TableColumn
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning

_ROW_PX: Final = 26


def modules_table(texts: Texts) -> RowsTable[ModuleToday]:
    return RowsTable(texts, "archive_modules", "Modules", _MODULE_COLUMNS, lambda row: row.module.members,
                     _accessible_text, row_px=_ROW_PX, is_single=True)  # fmt: skip


def history_table(texts: Texts) -> RowsTable[HistoryEvent]:
    return RowsTable(texts, "archive_life", "Records", _HISTORY_COLUMNS, lambda row: row.fact.id,
                     lambda row: row.text.translated(), row_px=_ROW_PX, is_single=True)  # fmt: skip


def short_station(public: str) -> str:
    """The beginning of its fingerprint."""
    return shown_station(public)[:9]


def _verdict(row: ModuleToday) -> str:
    return tr("none") if row.last_check is None else row.last_check.words.translated()


def _is_no_go(row: ModuleToday) -> bool:
    return row.last_check is not None and not row.last_check.holds


def _accessible_text(row: ModuleToday) -> str:
    return f"{clean(row.module.name)}: " + (row.due_words or tr("nothing due"))


def _local(at: str) -> str:
    return f"{datetime.fromisoformat(at).astimezone():%Y-%m-%d %H:%M}"


_MODULE_COLUMNS: Final = (
    TableColumn[ModuleToday](marked("Module"), lambda row: clean(row.module.name)),
    TableColumn[ModuleToday](marked("Stations"), lambda row: str(len({station for station, _ in row.module.members}))),
    TableColumn[ModuleToday](marked("Last check"), lambda row: _local(row.last_check.at) if row.last_check else ""),
    TableColumn[ModuleToday](
        marked("Verdict"), _verdict, ink=lambda row: Meaning.DANGER if _is_no_go(row) else None,
        picture=lambda row: icon(Icon.CROSS, Meaning.DANGER) if _is_no_go(row) else None,
    ),
    TableColumn[ModuleToday](marked("Trigger records"), lambda row: row.counted.translated()),
    TableColumn[ModuleToday](
        marked("Due"), lambda row: row.due_words,
        ink=lambda row: Meaning.ATTENTION if row.due else None,
        picture=lambda row: icon(Icon.WARNING, Meaning.ATTENTION) if row.due else None, stretches=True,
    ),
)  # fmt: skip
_HISTORY_COLUMNS: Final = (
    TableColumn[HistoryEvent](marked("Time"), lambda row: _local(row.fact.made_at)),
    TableColumn[HistoryEvent](marked("Station"), lambda row: short_station(row.fact.station)),
    TableColumn[HistoryEvent](marked("Record"), lambda row: row.text.translated(), stretches=True),
)
