"""Row of one setting: parameter, module value, editor, state with its reason or what the value means.

The reason has all the width beside its state, or in a narrow table a line of its own: the row grows for it.
"""

from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QBoxLayout, QFrame, QLabel, QSizePolicy, QToolButton, QWidget

from app.engine.device import How
from app.safety.consequences import Weight
from app.settings.form import FormRow, RowState
from app.settings.values import advice_text
from app.text.i18n import tr
from app.text.sentences import capitalised, join_sentences, with_units
from protocol.catalogue import Command
from protocol.fields import Quantity
from ui.forms.field_editors import (
    VALUE_PX,
    FieldEditor,
    FlagEditor,
    NumberEditor,
    ValueLabel,
    explain_setting,
    make_editor,
)
from ui.style.icons import Icon, StateStyle
from ui.style.theme import Meaning, Size, Space
from ui.widgets.controls import control, named, set_role
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_row
from ui.widgets.number_line import NumberKind
from ui.widgets.readout import StateChip

CELLS_PX: Final = 41
"""Height of a row without its margins, its line and its reason: 44 px in all."""
NAME_PX: Final = 160
WIDE_NAME_PX: Final = 190
"""Where the table has room for them."""
EDITOR_PX: Final = 192
STATE_PX: Final = 128
CELL_GAP: Final = Space.S
MARGINS: Final = (Space.S, 1, Space.S, 1)


STYLES: Final = {
    RowState.UNKNOWN: StateStyle(Icon.UNKNOWN, Meaning.UNKNOWN),
    RowState.READ: StateStyle(Icon.INFORMATION, None),
    RowState.ACKNOWLEDGED: StateStyle(Icon.INFORMATION, None),
    RowState.STALE: StateStyle(Icon.CLOCK, Meaning.UNKNOWN),
    RowState.EDITED: StateStyle(Icon.SETTINGS, Meaning.INFORMATION),
    RowState.IMPOSSIBLE: StateStyle(Icon.CROSS, Meaning.DANGER),
    RowState.WRITING: StateStyle(Icon.CONNECTING, Meaning.INFORMATION),
    RowState.VERIFIED: StateStyle(Icon.CHECK, Meaning.GOOD),
    RowState.CHANGED: StateStyle(Icon.WARNING, Meaning.DANGER),
    RowState.FAILED: StateStyle(Icon.CROSS, Meaning.DANGER),
}
WRONG: Final = (RowState.FAILED, RowState.CHANGED, RowState.IMPOSSIBLE)


class SettingsRow(QFrame):
    """Shows a `FormRow`; the signals are about what the user did."""

    chosen = Signal(str, object)
    """Key and value."""
    mistyped = Signal(str, str)
    """Key, and what was typed and cannot be sent."""
    cancelled = Signal(str)

    def __init__(self, command: Command) -> None:
        super().__init__()
        self.setObjectName(f"row_{command.name}")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        self.command = command
        self.row: FormRow | None = None
        self.name = named(QLabel(tr(command.title)), f"{command.name}_name")
        self.name.setWordWrap(True)
        self.value_label = ValueLabel(command)
        self.editor: FieldEditor = make_editor(command)
        self.state = named(StateChip("", size=Size.SMALL), f"{command.name}_state")
        self.reason = text_label(f"{command.name}_reason", "small")
        self.name.setBuddy(self.editor)
        explain_setting(self, command)
        self.state.setWhatsThis(tr("“Verified” means written, asked for again, and equal."))
        key = command.key
        self.editor.chosen.connect(lambda value: self.chosen.emit(key, value))
        self.discard = control(
            QToolButton(),
            f"{command.name}_discard",
            says=tr("Discard this edit"),
            picture=Icon.DISCARD,
            role="narrow",
            slot=lambda: self.cancelled.emit(key),
        )
        if isinstance(self.editor, FlagEditor | NumberEditor):
            self.editor.cancelled.connect(lambda: self.cancelled.emit(key))
        if isinstance(self.editor, NumberEditor):
            self.editor.mistyped.connect(lambda text: self.mistyped.emit(key, text))
        left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        cells = in_row(*aligned_cells(self.name, self.value_label, self.editor), (self.state, left), spacing=CELL_GAP)
        cells.addStrut(CELLS_PX)  # a reason below them moves none of them
        rest = in_row((self.reason, 1), 0, self.discard, spacing=CELL_GAP)
        self._layout: QBoxLayout = in_row(cells, (rest, 1), of=self, spacing=CELL_GAP, margins=MARGINS)

    def fold(self, *, is_narrow: bool) -> None:
        """Whether the reason lies below the cells; beside them, room is kept for the button that discards the edit."""
        direction = QBoxLayout.Direction
        self._layout.setDirection(direction.TopToBottom if is_narrow else direction.LeftToRight)
        self._layout.setSpacing(0 if is_narrow else CELL_GAP)
        policy = self.discard.sizePolicy()
        policy.setRetainSizeWhenHidden(not is_narrow)
        self.discard.setSizePolicy(policy)

    def show_row(self, row: FormRow, now: float, *, is_editable: bool) -> None:
        self.row = row
        self.value_label.show_known(row.module_value, now)
        if row.mistyped and isinstance(self.editor, NumberEditor):
            self.editor.show_mistyped(row.mistyped)
        else:
            self.editor.show_value(row.edited, None if row.module_value is None else row.module_value.value)
        self.editor.setEnabled(is_editable)
        self.discard.setVisible(row.edited is not None or bool(row.mistyped))
        self.discard.setEnabled(is_editable)
        style = STYLES[row.state]
        self.state.set_caption(tr(self.command.title))
        self.state.show_state(tr(row.state.value), style.icon, style.meaning)
        reason = reason_text(row)
        meaning = with_units(join_sentences(consequence.sentence for consequence in row.consequences))
        is_loud = any(consequence.weight is not Weight.PLAIN for consequence in row.consequences)
        is_wrong = row.state in WRONG
        # What a value takes away is said for as long as it stands, before why its row is in its state.
        is_warning = is_loud and not is_wrong
        self.reason.setText(meaning if is_warning else reason or meaning)
        self.reason.setVisible(bool(self.reason.text()))
        set_role(self.reason, "danger" if is_wrong else "attention" if is_warning else "small")
        set_role(self, "marked-row-failed" if is_wrong else "marked-row")
        tip = (reason, meaning, tr(self.command.explanation), capitalised(advice_text(self.command)))
        self.setToolTip("\n".join(line for line in tip if line))

    def add_beside_editor(self, button: QWidget) -> None:
        """Adds `button` to the right of the editor, next in the tab order."""
        layout = self.editor.layout()
        if layout is not None:
            layout.addWidget(button)


def aligned_cells(name: QLabel, value_label: QWidget, editor: QWidget) -> tuple[QWidget, ...]:
    """The first three columns, with the same widths in every row."""
    name.setFixedWidth(NAME_PX)
    value_label.setFixedWidth(VALUE_PX)
    return name, value_label, editor


def reason_text(row: FormRow) -> str:
    """Why the row is in its state; empty where the state says it all."""
    if row.mistyped and isinstance(row.command.write, Quantity):
        return NumberKind.of_field(row.command.write).range_text
    if row.reason:
        return row.reason
    if row.state is RowState.ACKNOWLEDGED and row.module_value is not None and row.module_value.how is How.ACKNOWLEDGED:
        return tr("cannot be read")
    return ""
