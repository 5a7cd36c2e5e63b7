"""One profile beside every module: differences, and the results of writing it."""

from collections.abc import Callable
from itertools import starmap
from typing import Final, NamedTuple

from PySide6.QtCore import Signal
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import QPushButton, QWidget

from app.fleet.profile_table import Applied, AppliedProfile, Column, settings_in
from app.settings.form import Match, ProfileRow
from app.settings.values import value_text
from app.text.i18n import tr
from app.text.sentences import join_names, labelled
from protocol.catalogue import Command
from protocol.translatable import marked
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import TableColumn
from ui.pages.fleet.group_jobs import GroupProfile
from ui.pages.fleet.members import FleetMembers
from ui.style.icons import MEANING_ICONS, icon
from ui.style.theme import Meaning, Space, scaled
from ui.widgets.controls import control
from ui.widgets.labels import text_label
from ui.widgets.layouts import FlowRow, in_column
from ui.widgets.step_button import StepButton

_ROW_PX: Final = 34
_RESULT_MEANINGS: Final = {
    Applied.WRITING: Meaning.INFORMATION,
    Applied.NOTHING_TO_DO: Meaning.GOOD,
    Applied.VERIFIED: Meaning.GOOD,
    Applied.ACKNOWLEDGED: Meaning.INFORMATION,
    Applied.REFUSED: Meaning.ATTENTION,
    Applied.FAILED: Meaning.DANGER,
    Applied.UNREACHABLE: Meaning.ATTENTION,
}


class _Row(NamedTuple):
    column: Column
    applied: AppliedProfile | None


class ProfilePanel(QWidget):
    """A row for each module, a column for each parameter, the result at the end."""

    closed = Signal()
    write_pressed = Signal()

    def __init__(self, group: GroupProfile, members: FleetMembers) -> None:
        super().__init__()
        self.setObjectName("fleet_profile_panel")
        self._group, self._members = group, members
        self.title = text_label("fleet_profile_title", "title")
        self.hint = text_label("fleet_profile_hint", "small")
        self.hint.setText(tr("Never written: baud rate, serial output, an active module."))
        self.close_button = control(QPushButton(tr("Back")), "fleet_profile_close", slot=self.closed)
        self.write = control(StepButton(tr("Write")), "fleet_profile_write", role="primary", slot=self.write_pressed)
        self._settings: tuple[Command, ...] = ()
        self.table: RowsTable[_Row] = RowsTable(
            "fleet_profile_table", tr("Profile"), (), lambda row: row.column.port, _row_text, row_px=scaled(_ROW_PX)
        )
        self.title.setWordWrap(False)
        head = FlowRow(self.title, right=(self.close_button, self.write))
        in_column(head, self.hint, (self.table, 1), of=self, spacing=Space.S, margins=(Space.M, Space.XS))

    def refresh(self) -> None:
        profile = self._group.profile
        if profile is None:
            return
        self.title.setText(labelled(tr("Profile"), profile.name))
        settings = settings_in(profile)
        if settings != self._settings:
            self._settings = settings
            self.table.show_columns([_MODULE, *starmap(_setting_column, enumerate(settings)), _RESULT])
        connections = self._members.connections
        rows = [
            _Row(self._group.column(one), self._group.result(one) or self._group.foreseen(one)) for one in connections
        ]
        self.table.show_rows(rows)
        differing, writable = sum(bool(row.column.changes) for row in rows), len(self._group.writable)
        self.write.setEnabled(writable > 0 and not self._group.is_running)
        self.write.setText(tr("Write ({count})", count=writable) if differing else tr("No changes"))
        self.close_button.setEnabled(not self._group.is_running)


def _module(row: _Row) -> str:
    return f"{row.column.title or tr('Unnamed')} · {row.column.port}"


def _row_text(row: _Row) -> str:
    return join_names((_module(row), *(_cell(setting)[0] for setting in row.column.rows), _result(row)[0]))


def _setting_column(number: int, command: Command) -> TableColumn[_Row]:
    return _column(command.title, lambda row: _cell(row.column.rows[number]))


def _column(title: str, cell: Callable[[_Row], tuple[str, Meaning | None]]) -> TableColumn[_Row]:
    """In the colour of its meaning, with its icon."""

    def picture(row: _Row) -> QIcon | None:
        meaning = cell(row)[1]
        return None if meaning is None else icon(MEANING_ICONS[meaning])

    return TableColumn(title, lambda row: cell(row)[0], picture=picture, ink=lambda row: cell(row)[1])


def _cell(row: ProfileRow) -> tuple[str, Meaning | None]:
    target = "" if row.target is None else value_text(row.command, row.target)
    if row.match is Match.SAME:
        return target, None
    module_value = tr("unknown")
    if row.match is Match.DIFFERENT and row.module_value is not None:
        module_value = value_text(row.command, row.module_value.value)
    return f"{module_value} → {target}", Meaning.ATTENTION if row.match is Match.DIFFERENT else Meaning.UNKNOWN


def _result(row: _Row) -> tuple[str, Meaning | None]:
    applied = row.applied
    if applied is None:
        return "", None
    text, why = tr(applied.state.value), applied.sentence
    return labelled(text, why) if why else text, _RESULT_MEANINGS[applied.state]


_MODULE: Final = TableColumn[_Row](marked("Module"), _module)
_RESULT: Final = _column(marked("Result"), _result)
