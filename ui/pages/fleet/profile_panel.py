"""One profile beside every module: differences, and the results of writing it."""

from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QColor, QIcon
from PySide6.QtWidgets import QPushButton, QTableWidget, QTableWidgetItem, QWidget

from app.fleet.profile_table import Applied, AppliedProfile, Column, settings_in
from app.settings.profiles import Match, ProfileRow
from app.settings.setting_texts import value_text
from app.text.i18n import tr
from ui.core.port_connection import PortConnection
from ui.forms.table_kit import list_rows
from ui.pages.fleet.group_jobs import GroupProfile
from ui.pages.fleet.members import FleetMembers
from ui.services.context import Services
from ui.style.icons import MEANING_ICONS, icon
from ui.style.theme import Meaning, Space, Theme, current, scaled
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


class ProfilePanel(QWidget):
    """A row for each module, a column for each parameter, the result at the end."""

    closed = Signal()
    write_pressed = Signal()

    def __init__(self, services: Services, group: GroupProfile, members: FleetMembers) -> None:
        super().__init__()
        self.setObjectName("fleet_profile_panel")
        self._group, self._members = group, members
        texts = services.texts
        self.title = text_label("fleet_profile_title", "title")
        self.hint = text_label("fleet_profile_hint", "small")
        texts.bind(
            self.hint.setText,
            "Never written: baud rate, serial output, an active module.",
        )
        self.close_button = control(QPushButton(), texts, "fleet_profile_close", "Back", slot=self.closed)
        self.write = control(StepButton(), texts, "fleet_profile_write", "Write", role="primary",
                             slot=self.write_pressed)  # fmt: skip
        self._shown: dict[tuple[int, int], tuple[str, Meaning | None, Theme]] = {}
        """What each cell shows, by row and column, in which theme."""
        self.table = control(
            QTableWidget(),
            texts,
            "fleet_profile_table",
            says="Profile",
        )
        self.table.horizontalHeader().setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        self.title.setWordWrap(False)
        list_rows(self.table, row_px=scaled(_ROW_PX))
        head = FlowRow(spacing_px=Space.S)
        head.add(self.title)
        head.add_right(self.close_button, self.write)
        in_column(head, self.hint, (self.table, 1), of=self, spacing=Space.S, margins=(Space.M, Space.XS))

    def refresh(self) -> None:
        """Update the cells whose text changed."""
        profile = self._group.profile
        if profile is None:
            return
        settings = settings_in(profile)
        heads = [tr("Module"), *(tr(one.title) for one in settings), tr("Result")]
        connections = self._members.connections
        self.title.setText(tr("Profile: {name}", name=profile.name))
        if self.table.columnCount() != len(heads) or self.table.rowCount() != len(connections):
            self.table.setColumnCount(len(heads))
            self.table.setRowCount(len(connections))
        self.table.setHorizontalHeaderLabels(heads)
        differing = 0
        for row, connection in enumerate(connections):
            column = self._group.column(connection)
            differing += bool(column.changes) and column.is_reachable
            self._fill_row(row, connection, column)
        self.table.resizeColumnsToContents()
        self.write.setEnabled(differing > 0 and not self._group.is_running)
        self.write.setText(tr("Write ({count})", count=differing) if differing else tr("No changes"))
        self.close_button.setEnabled(not self._group.is_running)

    def _fill_row(self, row: int, connection: PortConnection, column: Column) -> None:
        title = column.title or tr("Unnamed")
        self._put(row, 0, f"{title} · {column.port}", None)
        for number, one in enumerate(column.rows, 1):
            text, meaning = _cell(one)
            self._put(row, number, text, meaning)
        applied = self._group.applied.get(connection)
        text, meaning = _result(applied)
        self._put(row, len(column.rows) + 1, text, meaning)

    def _put(self, row: int, place: int, text: str, meaning: Meaning | None) -> None:
        item = self.table.item(row, place)
        if item is None:
            item = QTableWidgetItem()
            item.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable)
            self.table.setItem(row, place, item)
        shown = (text, meaning, current())
        if self._shown.get((row, place)) != shown:
            self._shown[row, place] = shown
            item.setText(text)
            item.setToolTip(text)
            item.setForeground(current().ink(meaning) if meaning is not None else QColor(current().text))
            item.setIcon(QIcon() if meaning is None else icon(MEANING_ICONS[meaning]))


def _cell(row: ProfileRow) -> tuple[str, Meaning | None]:
    wanted = "" if row.wanted is None else value_text(row.command, row.wanted)
    if row.match is Match.SAME:
        return wanted, None
    stands = tr("unknown")
    if row.match is Match.DIFFERENT and row.stands is not None:
        stands = value_text(row.command, row.stands.value)
    return f"{stands} → {wanted}", Meaning.ATTENTION if row.match is Match.DIFFERENT else Meaning.UNKNOWN


def _result(applied: AppliedProfile | None) -> tuple[str, Meaning | None]:
    if applied is None:
        return "", None
    text = tr(applied.state.value)
    return f"{text}: {applied.why}" if applied.why else text, _RESULT_MEANINGS[applied.state]
