"""Row of one setting: parameter, module value, editor, state with its reason; and the pane of the chosen one.

The reason has all the width beside its state, or in a narrow table a line of its own: the row grows for it.
"""

from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QBoxLayout, QFrame, QLabel, QSizePolicy, QWidget

from app.engine.device import How
from app.procedures.power_cycle import Retention
from app.safety.consequences import Weight
from app.settings.form import FormRow, RowState
from app.settings.setting_texts import advice_text, value_text
from app.text.i18n import tr
from app.text.sentences import capitalised, join_sentences, with_units
from protocol.catalogue import Command
from ui.core.texts import Texts
from ui.forms.field_editors import VALUE_PX, FieldEditor, FlagEditor, ValueLabel, explain_setting, make_editor
from ui.style.icons import Icon, StateStyle
from ui.style.theme import Meaning, Size, Space
from ui.widgets.controls import control, named, set_role
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_column, in_row, scroll_area
from ui.widgets.readout import StateChip

CELLS_PX: Final = 41
"""Height of a row without its margins, its line and its reason: 44 px in all."""
NAME_PX: Final = 160
WIDE_NAME_PX: Final = 190
"""Where the pane leaves the table room for them."""
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
    RowState.WRITING: StateStyle(Icon.CONNECTING, Meaning.INFORMATION),
    RowState.VERIFIED: StateStyle(Icon.CHECK, Meaning.GOOD),
    RowState.CHANGED: StateStyle(Icon.WARNING, Meaning.DANGER),
    RowState.FAILED: StateStyle(Icon.CROSS, Meaning.DANGER),
}
WRONG: Final = (RowState.FAILED, RowState.CHANGED)


class SettingsRow(QFrame):
    """Shows a `FormRow`; the signals are about what the user did."""

    chosen = Signal(str, object)
    """Key and value."""
    cancelled = Signal(str)
    left = Signal()
    pressed = Signal(str)
    """Key; the row was clicked beside its editor."""

    def __init__(self, command: Command, texts: Texts) -> None:
        super().__init__()
        self.setObjectName(f"row_{command.name}")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        self.command = command
        self.row: FormRow | None = None
        self.name = control(QLabel(), texts, f"{command.name}_name", command.title)
        self.name.setWordWrap(True)
        self.value_label = ValueLabel(command)
        self.editor: FieldEditor = make_editor(command, texts)
        self.state = named(StateChip("", size=Size.SMALL), f"{command.name}_state")
        self.reason = text_label(f"{command.name}_reason", "small")
        self.name.setBuddy(self.editor)
        explain_setting(texts, self, command)
        texts.bind(self.state.setWhatsThis, "“Verified” means written, asked for again, and equal.")
        key = command.key
        self.editor.chosen.connect(lambda value: self.chosen.emit(key, value))
        self.editor.left.connect(self.left)
        if isinstance(self.editor, FlagEditor):
            self.editor.cancelled.connect(lambda: self.cancelled.emit(key))
        left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        cells = in_row(*aligned_cells(self.name, self.value_label, self.editor), (self.state, left), spacing=CELL_GAP)
        cells.addStrut(CELLS_PX)  # a reason below them moves none of them
        self._layout: QBoxLayout = in_row(cells, (self.reason, 1), of=self, spacing=CELL_GAP, margins=MARGINS)

    def fold(self, *, is_narrow: bool) -> None:
        """Whether the reason lies below the cells."""
        direction = QBoxLayout.Direction
        self._layout.setDirection(direction.TopToBottom if is_narrow else direction.LeftToRight)
        self._layout.setSpacing(0 if is_narrow else CELL_GAP)

    def show_row(self, row: FormRow, now: float, *, is_editable: bool, is_chosen: bool) -> None:
        self.row = row
        self.value_label.show_known(row.module_value, now)
        self.editor.show_value(row.edited, None if row.module_value is None else row.module_value.value)
        self.editor.setEnabled(is_editable)
        style = STYLES[row.state]
        self.state.set_caption(tr(self.command.title))
        self.state.show_state(tr(row.state.value), style.icon, style.meaning)
        loud = (consequence.sentence for consequence in row.consequences if consequence.weight is not Weight.PLAIN)
        reason, warning = reason_text(row), join_sentences(loud)
        is_wrong = row.state in WRONG
        self.reason.setText(reason or warning)
        self.reason.setVisible(bool(self.reason.text()))
        set_role(self.reason, "danger" if is_wrong else "attention" if warning and not reason else "small")
        set_role(self, "marked-row-failed" if is_wrong else "marked-row-chosen" if is_chosen else "marked-row")

    def add_beside_editor(self, button: QWidget) -> None:
        """Adds `button` to the right of the editor, next in the tab order."""
        layout = self.editor.layout()
        if layout is not None:
            layout.addWidget(button)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        super().mousePressEvent(event)
        self.pressed.emit(self.command.key)


def aligned_cells(name: QLabel, value_label: QWidget, editor: QWidget) -> tuple[QWidget, ...]:
    """The first three columns, with the same widths in every row."""
    name.setFixedWidth(NAME_PX)
    value_label.setFixedWidth(VALUE_PX)
    return name, value_label, editor


def reason_text(row: FormRow) -> str:
    """Why the row is in its state; empty where the state says it all."""
    if row.reason:
        return row.reason
    retention = row.retention
    if retention is not None and not row.is_pending:
        if retention.result is Retention.RETAINED:
            return tr("Kept over the power cycle.")
        if retention.result is Retention.LOST and retention.read_back is not None:
            read_back = value_text(row.command, retention.read_back)
            return tr("LOST at the power cycle: it holds {stands}.", stands=read_back)
        return tr("Power cycle: {fate}.", fate=tr(retention.result.value))
    if row.state is RowState.ACKNOWLEDGED and row.module_value is not None and row.module_value.how is How.ACKNOWLEDGED:
        return tr("cannot be read")
    return ""


class SettingPane(QFrame):
    """Explanation, consequences and vendor's advice of the chosen setting."""

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        named(self, "setting_pane", "card")
        self.title = text_label("setting_title", "strong")
        self.term = text_label("setting_term", "small")
        self.what = text_label("setting_what")
        self.meaning = text_label("setting_meaning")
        self.reason = text_label("setting_reason", "small")
        self.advice = text_label("setting_advice", "small")
        self.heading = named(QWidget(), "setting_heading")
        """Below the table the chosen row is heading enough."""
        in_column(self.title, self.term, of=self.heading, spacing=0, margins=0)
        content = named(QWidget(), "setting_content")
        in_column(
            self.heading, self.reason, self.meaning, self.what, self.advice, 1,
            of=content, spacing=Space.XS, margins=(Space.M, Space.XS),
        )  # fmt: skip
        scroll = scroll_area(content, texts, "setting_scroll", "Parameter", is_transparent=True)
        in_column(scroll, of=self, margins=1)

    def show_row(self, row: FormRow) -> None:
        command = row.command
        title, term = tr(command.title), command.vendor_term
        is_loud = any(consequence.weight is not Weight.PLAIN for consequence in row.consequences)
        for label, text in (
            (self.title, title),
            (self.term, "" if term == title else term),  # in Chinese it is the title
            (self.reason, reason_text(row)),
            (self.what, tr(command.explanation)),
            (self.meaning, with_units(join_sentences(consequence.sentence for consequence in row.consequences))),
            (self.advice, capitalised(advice_text(command))),
        ):
            label.setText(text)
            label.setVisible(bool(text))
        set_role(self.reason, "danger" if row.state in WRONG else "small")
        set_role(self.meaning, "attention" if is_loud else "")
