"""The table of settings: one row each with the module's value, the field for another one, the state, and what the value
means or why it is in its state."""

from collections.abc import Callable, Mapping
from typing import Final

from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import QAbstractButton, QFrame, QGridLayout, QLabel, QToolButton, QWidget

from app.engine.conversation import How
from app.safety.consequences import Weight
from app.settings.form import FORM_COMMANDS, FormRow, RowState
from app.settings.values import DEFAULTS, advice_text, value_text
from app.text.i18n import tr
from app.text.messages import capitalised, join_sentences, labelled, with_units
from protocol.catalogue import Command
from protocol.fields import Quantity
from protocol.translatable import marked
from ui.forms.field_editors import FieldEditor, HeldValue, make_editor
from ui.session.settings_draft import SettingsDraft
from ui.style.icons import Icon, StateStyle
from ui.style.theme import Meaning, Size, Space, is_text_large
from ui.widgets.controls import IconLabel, control, in_row, named, retain_size, set_role, text_label
from ui.widgets.number_line import NumberKind

# Without a meaning a state is muted: a table in which nothing is to be done is calm.
STYLES: Final[Mapping[RowState, StateStyle]] = {
    RowState.UNKNOWN: StateStyle(Icon.UNKNOWN, None),
    RowState.READ: StateStyle(Icon.INFORMATION, None),
    RowState.ACKNOWLEDGED: StateStyle(Icon.INFORMATION, None),
    RowState.STALE: StateStyle(Icon.CLOCK, None),
    RowState.EDITED: StateStyle(Icon.SETTINGS, Meaning.INFORMATION),
    RowState.IMPOSSIBLE: StateStyle(Icon.CROSS, Meaning.DANGER),
    RowState.WRITING: StateStyle(Icon.CONNECTING, Meaning.INFORMATION),
    RowState.VERIFIED: StateStyle(Icon.CHECK, Meaning.GOOD),
    RowState.FAILED: StateStyle(Icon.CROSS, Meaning.DANGER),
}
# What a value takes away looks like every other warning.
WARNED: Final = StateStyle(Icon.WARNING, Meaning.ATTENTION)
HEADS: Final = (marked("Parameter"), marked("Module"), marked("New value"), marked("State"))
# Of each column in the width: parameter, module, new value, state, what it means, buttons.
SHARES: Final = (30, 24, 25, 23, 37, 0)
# Large text has no room for all of it side by side: what a value means lies below it.
LARGE_SHARES: Final = (4, 4, 5)
MIDDLE: Final = Qt.AlignmentFlag.AlignVCenter


class SettingsTable(QFrame):
    """All rows in one grid, so that their columns are aligned."""

    def __init__(self, find_work: Callable[[], SettingsDraft]) -> None:
        super().__init__()
        named(self, "settings_table", "card")
        self.grid = QGridLayout(self)
        self.grid.setContentsMargins(Space.M, Space.S, Space.S, Space.S)
        self.grid.setHorizontalSpacing(Space.M)
        self.grid.setVerticalSpacing(Space.XS)
        self.shares = LARGE_SHARES if is_text_large() else SHARES
        for column, share in enumerate(self.shares):
            self.grid.setColumnStretch(column, share)
        for column, english in enumerate(HEADS[: len(self.shares)]):
            self.grid.addWidget(named(QLabel(tr(english)), f"settings_head_{column}", "caption"), 0, column)
        self.grid.addWidget(named(QFrame(), "settings_head_line", "line"), 1, 0, 1, len(self.shares))
        self.rows: dict[str, SettingRow] = {}
        for command in FORM_COMMANDS:
            self.rows[command.key] = SettingRow(self, command, find_work)
            # So that the eye keeps to a row across the width.
            line = named(QFrame(), f"{command.name}_line", "line")
            self.grid.addWidget(line, self.grid.rowCount(), 0, 1, len(self.shares))

    def add_cells(self, *cells: QWidget) -> int:
        """The first cells of another row; its number."""
        place = self.grid.rowCount()
        for column, cell in enumerate(cells):
            self.grid.addWidget(cell, place, column, MIDDLE)
        return place


class SettingRow(QObject):
    """The cells of one setting."""

    def __init__(self, table: SettingsTable, command: Command, find_work: Callable[[], SettingsDraft]) -> None:
        super().__init__(table)
        self.command = command
        name, key, title = command.name, command.key, tr(command.title)
        self.name = text_label(f"{name}_name")
        self.name.setText(title)
        self.held = HeldValue(command)
        self.editor: FieldEditor = make_editor(command)
        self.name.setBuddy(self.editor)
        self.picture = IconLabel(f"{name}_state_icon", Size.BODY)
        self.state = named(QLabel(), f"{name}_state")
        self.reason = text_label(f"{name}_reason", "small")
        self.default = control(QToolButton(), f"{name}_default", text=tr("Default"), role="narrow")
        self.discard = control(QToolButton(), f"{name}_discard", picture=Icon.DISCARD, role="narrow")
        self._name_buttons()
        self.editor.chosen.connect(lambda value: find_work().choose(key, value))
        self.editor.mistyped.connect(lambda text: find_work().mistype(key, text))
        for cancelled in (self.editor.cancelled, self.discard.clicked):
            cancelled.connect(lambda: find_work().revert(key))
        self.default.clicked.connect(lambda: find_work().choose(key, DEFAULTS[key]))
        self._lay_out(table)

    def add_button(self, button: QAbstractButton) -> None:
        """In the place of the default, for a setting that has none."""
        self._buttons.insertWidget(1, button)

    def show_row(self, row: FormRow, now: float, *, is_editable: bool) -> None:
        self.held.show_known(row.module_value, now)
        held = None if row.module_value is None else row.module_value.value
        if row.mistyped:
            self.editor.show_mistyped(row.mistyped)
        else:
            self.editor.show_value(row.edited, held)
        stands = row.mistyped or (held if row.edited is None else row.edited)
        default = DEFAULTS.get(self.command.key)
        self.default.setVisible(default is not None and stands != default)
        self.discard.setVisible(row.edited is not None or bool(row.mistyped))
        for widget in (self.editor, self.default, self.discard):
            widget.setEnabled(is_editable)
        is_bad = row.state in (RowState.FAILED, RowState.IMPOSSIBLE)
        is_loud = not is_bad and any(consequence.weight is not Weight.PLAIN for consequence in row.consequences)
        word = tr(row.state.value)
        self.state.setText(word)
        self.state.setAccessibleName(labelled(tr(self.command.title), word))
        style = WARNED if is_loud else STYLES[row.state]
        self.picture.show_icon(style.icon, style.meaning, is_muted=style.meaning is None)
        set_role(self.state, "muted" if style.meaning is None else "")
        self._show_reason(row, is_bad=is_bad, is_loud=is_loud)

    def _show_reason(self, row: FormRow, *, is_bad: bool, is_loud: bool) -> None:
        """What a value takes away is said for as long as it stands, before why its row is in its state."""
        reason = reason_text(row)
        meaning = with_units(join_sentences(consequence.sentence for consequence in row.consequences))
        if is_bad:
            self.reason.setText(reason)
            set_role(self.reason, "danger")
        elif is_loud:
            self.reason.setText(meaning)
            set_role(self.reason, "attention")
        else:
            self.reason.setText(reason or meaning)
            set_role(self.reason, "small")
        tip = (reason, meaning, tr(self.command.explanation), capitalised(advice_text(self.command)))
        for cell in (self.name, self.held, self.state, self.reason):
            cell.setToolTip("\n".join(line for line in tip if line))

    def _name_buttons(self) -> None:
        title, key = tr(self.command.title), self.command.key
        default = value_text(self.command, DEFAULTS[key]) if key in DEFAULTS else ""
        texts = ((self.default, tr("Default {value}", value=default)), (self.discard, tr("Discard this edit")))
        for button, text in texts:
            button.setToolTip(text)
            button.setAccessibleName(labelled(title, text))
        for button in (self.default, self.discard) if key in DEFAULTS else (self.discard,):
            retain_size(button)  # so that none of them ever takes the other's place

    def _lay_out(self, table: SettingsTable) -> None:
        place = table.add_cells(self.name, self.held, self.editor)
        state = in_row(self.picture, self.state, 1, spacing=Space.XS, margins=0)
        self._buttons = in_row(1, self.default, self.discard, spacing=Space.XS, margins=0)
        if table.shares is LARGE_SHARES:
            table.grid.addLayout(state, place + 1, 0)
            table.grid.addLayout(self._buttons, place + 1, 1, 1, 2)
            table.grid.addWidget(self.reason, place + 2, 0, 1, 3)
        else:
            table.grid.addLayout(state, place, 3)
            table.grid.addWidget(self.reason, place, 4, MIDDLE)
            table.grid.addLayout(self._buttons, place, 5)


def reason_text(row: FormRow) -> str:
    """Why the row is in its state; empty where the state says it all."""
    if row.mistyped and isinstance(row.command.write, Quantity):
        return NumberKind.of_field(row.command.write).range_text
    if row.reason:
        return row.reason
    if row.state is RowState.ACKNOWLEDGED and row.module_value is not None and row.module_value.how is How.ACKNOWLEDGED:
        return tr("cannot be read")
    return ""
