"""Row of one setting: name, module value, editor, meaning, state."""

from collections.abc import Mapping
from typing import Final, NamedTuple

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QGridLayout, QLabel, QPushButton, QSizePolicy

from app.diagnosis.link_state import duration
from app.engine.device import How, StaleReason
from app.procedures.power_cycle import Retention
from app.settings.consequences import Weight
from app.settings.form import FormRow, RowState
from app.settings.setting_texts import advice_text, value_text, what_is
from app.text.i18n import tr
from app.text.sentences import begun, together
from protocol.catalogue import Command
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.forms.field_editors import FieldEditor, FlagEditor, make_editor
from ui.forms.value_label import ValueLabel
from ui.style.icons import Icon
from ui.style.theme import Meaning, Size, Space
from ui.widgets.controls import control
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_column, in_row
from ui.widgets.naming import named
from ui.widgets.readout import StateChip
from ui.widgets.sliders import WheelGuard

NAME_PX: Final = 148
EDITOR_PX: Final = 200
STATE_PX: Final = 144


class _Look(NamedTuple):
    icon: Icon
    meaning: Meaning | None


LOOKS: Final = {
    RowState.UNKNOWN: _Look(Icon.UNKNOWN, Meaning.UNKNOWN),
    RowState.READ: _Look(Icon.INFORMATION, None),
    RowState.ACKNOWLEDGED: _Look(Icon.INFORMATION, None),
    RowState.STALE: _Look(Icon.CLOCK, Meaning.UNKNOWN),
    RowState.EDITED: _Look(Icon.SETTINGS, Meaning.INFORMATION),
    RowState.UNFIT: _Look(Icon.WARNING, Meaning.ATTENTION),
    RowState.WRITING: _Look(Icon.CONNECTING, Meaning.INFORMATION),
    RowState.VERIFIED: _Look(Icon.CHECK, Meaning.GOOD),
    RowState.CHANGED: _Look(Icon.WARNING, Meaning.DANGER),
    RowState.FAILED: _Look(Icon.CROSS, Meaning.DANGER),
}


DOUBTS: Final[Mapping[StaleReason, str]] = {
    StaleReason.RESTARTED: marked("The module restarted since."),
    StaleReason.LINK_LOST: marked("The link was lost since."),
    StaleReason.WRITE_UNCONFIRMED: marked("A write since was not confirmed."),
    StaleReason.AGED: marked("Nothing was heard of it for long."),
    StaleReason.LATE: marked("What the module says arrives late."),
}


def _verified_age(row: FormRow, now: float) -> str:
    """ "verified" is as old as the reading that last confirmed it."""
    if row.state is not RowState.VERIFIED or row.stands is None:
        return ""
    return tr("{time} ago", time=duration(max(0.0, now - row.stands.at)))


class SettingsRow(QFrame):
    """`show_row` shows; the signals tell what a person did."""

    typed = Signal(str, str)
    """Key and the text so far."""
    chosen = Signal(str, object)
    """Key and value."""
    cancelled = Signal(str)
    left = Signal()
    measure_wanted = Signal()
    """The light threshold by measurement."""

    def __init__(self, command: Command, texts: Texts, guard: WheelGuard) -> None:
        super().__init__()
        self.setObjectName(f"row_{command.name}")
        self.command = command
        self.row: FormRow | None = None
        self._name = control(QLabel(), texts, f"{command.name}_name", command.title, role="strong")
        self._name.setWordWrap(True)
        self._vendor = named(QLabel(command.vendor_term), f"{command.name}_vendor", "small")
        self.stands = ValueLabel(command)
        self.editor: FieldEditor = make_editor(command, texts, guard)
        self.advice = text_label(f"{command.name}_advice", "small")
        self.state = named(StateChip("", size=Size.SMALL), f"{command.name}_state")
        self.reason = text_label(f"{command.name}_reason", "small")
        self.meaning = text_label(f"{command.name}_consequence", "small")
        self.measure = control(QPushButton(), texts, f"{command.name}_measure", "Measure…",
                               says="Find the light threshold by measuring",
                               tip="Measure with the bay closed, then open, and take a threshold between",
                               picture=Icon.LIGHT, slot=self.measure_wanted)  # fmt: skip
        self.measure.setVisible(command.name == "light_threshold")
        self.measure.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self._name.setBuddy(self.editor)
        texts.bind(self._say_what, command.explanation)
        key = command.key
        self.editor.typed.connect(lambda text: self.typed.emit(key, text))
        self.editor.chosen.connect(lambda value: self.chosen.emit(key, value))
        self.editor.left.connect(self.left)
        if isinstance(self.editor, FlagEditor):
            self.editor.cancelled.connect(lambda: self.cancelled.emit(key))
        self._lay_out()

    def show_row(self, row: FormRow, now: float, *, is_editable: bool) -> None:
        self.row = row
        self.stands.show_known(row.stands, now)
        self._vendor.setVisible(self._name.text() != self.command.vendor_term)  # in Chinese it is the title
        self.editor.show_draft(row.draft, None if row.stands is None else row.stands.value)
        self.editor.setEnabled(is_editable)
        self.advice.setText(begun(advice_text(self.command)))
        look = LOOKS[row.state]
        self.state.set_caption(tr("State of {setting}", setting=tr(self.command.title)))
        self.state.show_state(tr(row.state.value), look.icon, look.meaning)
        self.state.set_age(_verified_age(row, now))
        self.reason.setText(self._reason_text(row))
        is_wrong = row.state in (RowState.FAILED, RowState.CHANGED)
        self._set_role(self.reason, "danger" if is_wrong else "small")
        said = row.consequences
        is_loud = any(one.weight is not Weight.PLAIN for one in said)
        self.meaning.setText(together(one.sentence for one in said))
        self.meaning.setVisible(bool(said))
        self._set_role(self.meaning, "attention" if is_loud else "small")
        self._set_role(self, "row-failed" if is_wrong else "row")

    def _say_what(self, _explanation: str) -> None:
        self.setWhatsThis(what_is(self.command))

    def _reason_text(self, row: FormRow) -> str:
        if row.reason:
            return row.reason
        if row.state is RowState.STALE and row.stands is not None and row.stands.stale_reason is not None:
            return tr(DOUBTS[row.stands.stale_reason])
        if row.stamp is not None and not row.is_pending:
            if row.stamp.fate is Retention.KEPT:
                return tr("Kept over the power cycle.")
            if row.stamp.fate is Retention.LOST and row.stamp.stands is not None:
                stands = value_text(self.command, row.stamp.stands)
                return tr("LOST at the power cycle: it holds {stands}.", stands=stands)
            return tr("Power cycle: {fate}.", fate=tr(row.stamp.fate.value))
        if row.is_pending and row.stands is None and not row.command.reads_back:
            return tr("It can be set and acknowledged, not read back.")
        if row.state is RowState.VERIFIED:
            return tr("Written and read back equal.")
        if row.state is RowState.ACKNOWLEDGED and row.stands is not None and row.stands.how is How.ACKNOWLEDGED:
            return tr("Received; it cannot be read back.")
        return ""

    @staticmethod
    def _set_role(widget: QFrame | QLabel, role: str) -> None:
        if widget.property("role") != role:
            widget.setProperty("role", role)
            widget.style().unpolish(widget)
            widget.style().polish(widget)

    def _lay_out(self) -> None:
        grid = QGridLayout(self)
        grid.setContentsMargins(Space.M, Space.S, Space.M, Space.S)
        grid.setHorizontalSpacing(Space.M)
        grid.setVerticalSpacing(Space.XS)
        names = in_column(self._name, self._vendor, 1, spacing=0)
        wanted = in_column(self.editor, self.advice, 1, spacing=2)
        state = in_column(self.state, self.reason, 1, spacing=2)
        top = Qt.AlignmentFlag.AlignTop
        grid.addLayout(names, 0, 0)
        grid.addWidget(self.stands, 0, 1, alignment=top)
        grid.addLayout(wanted, 0, 2)
        grid.addLayout(state, 0, 3)
        below = in_row((self.meaning, 1), spacing=Space.M)
        below.addWidget(self.measure, alignment=Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignRight)
        grid.addLayout(below, 1, 0, 1, 4)
        for column, (width, stretch) in enumerate(((NAME_PX, 2), (0, 0), (EDITOR_PX, 1), (STATE_PX, 4))):
            grid.setColumnMinimumWidth(column, width)
            grid.setColumnStretch(column, stretch)
