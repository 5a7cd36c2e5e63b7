"""The table of settings: one row each with the module's value, the field for another one, the state, and what the value
means or why it is in its state; last the baud rate, which is no setting like the others, as changing it can cut the
link."""

from collections.abc import Callable, Mapping
from typing import Final

from PySide6.QtCore import QObject, QSignalBlocker, Qt
from PySide6.QtWidgets import QComboBox, QFrame, QGridLayout, QLabel, QToolButton, QWidget

from app.engine.conversation import How, Known
from app.safety.journal import TITLES, Act
from app.settings.form import FORM_COMMANDS, RowState, SettingDraft
from app.settings.values import DEFAULTS, advice_text, value_text
from app.text.i18n import tr
from app.text.messages import capitalised, duration, join_sentences, labelled, with_units
from protocol.catalogue import BAUD_RATE, Command
from protocol.fields import Choice, Quantity, Value
from protocol.translatable import marked
from ui.acts.act_row import is_blocked, open_conditions
from ui.acts.confirm import Confirm
from ui.services.context import Services
from ui.session.settings_draft import SettingsDraft
from ui.style.icons import Icon, StateStyle
from ui.style.theme import Meaning, Size, Space, is_text_large
from ui.widgets.controls import (
    IconLabel,
    TickingLabel,
    control,
    in_column,
    in_row,
    named,
    retain_size,
    set_role,
    text_label,
)
from ui.widgets.number_line import NumberKind, NumberLine, WheelGuard

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
_HOW: Final[Mapping[How, str]] = {
    How.READ: marked("read {time} ago"),
    How.ACKNOWLEDGED: marked("acknowledged {time} ago"),
    How.STREAMED: marked("seen {time} ago"),
}
# Of each column in the width: parameter, module, new value, state, what it means, buttons.
_SHARES: Final = (30, 23, 20, 22, 44, 0)
# Large text has no room for all of it side by side: what a value means lies below it.
_LARGE_SHARES: Final = (4, 4, 5)


class SettingsTable(QFrame):
    """The table has all rows in one grid, so that their columns are aligned."""

    def __init__(self, find_work: Callable[[], SettingsDraft], services: Services) -> None:
        super().__init__()
        named(self, "settings_table", "card")
        self.is_large = is_text_large()
        self.grid = QGridLayout(self)
        self.grid.setContentsMargins(Space.M, Space.S, Space.S, Space.S)
        self.grid.setHorizontalSpacing(Space.M)
        self.grid.setVerticalSpacing(Space.XS)
        for column, share in enumerate(_LARGE_SHARES if self.is_large else _SHARES):
            self.grid.setColumnStretch(column, share)
        heads = (tr("Parameter"), tr("Module"), tr("New value"), tr("State"))
        for column, head in enumerate(heads[: len(_LARGE_SHARES)] if self.is_large else heads):
            self.grid.addWidget(named(QLabel(head), f"settings_head_{column}", "caption"), 0, column)
        self.add_below(named(QFrame(), "settings_head_line", "line"))
        self.rows: dict[str, SettingRow] = {}
        for command in FORM_COMMANDS:
            self.rows[command.key] = SettingRow(self, command, find_work)
            # So that the eye keeps to a row across the width.
            self.add_below(named(QFrame(), f"{command.name}_line", "line"))
        self.baud = BaudRow(self, services)

    def add_cells(self, *cells: QWidget) -> int:
        """The first cells of another row; its number."""
        place = self.grid.rowCount()
        for column, cell in enumerate(cells):
            self.grid.addWidget(cell, place, column, Qt.AlignmentFlag.AlignVCenter)
        return place

    def add_below(self, widget: QWidget) -> None:
        """Over the whole width."""
        self.grid.addWidget(widget, self.grid.rowCount(), 0, 1, self.grid.columnCount())


class HeldValue(QWidget):
    """The value that the module holds of one setting, and below it how that is known."""

    def __init__(self, command: Command) -> None:
        super().__init__()
        self._command = command
        self.value = named(QLabel(), f"{command.name}_stands", "strong")
        self.how = named(TickingLabel(), f"{command.name}_stands_how", "small", says=tr(command.title))
        self.how.setWordWrap(True)
        in_column(self.value, self.how, of=self, spacing=0, margins=0)

    def show_known(self, known: Known | None, now: float) -> None:
        if known is None:
            text = tr("unknown")
            note = tr("not read yet") if self._command.reads_back else tr("cannot be read")
        else:
            text = value_text(self._command, known.value)
            note = tr(_HOW[known.how], time=duration(max(0.0, now - known.at)))
        self.value.setText(text)
        title = tr(self._command.title)
        self.value.setAccessibleName(tr("{setting} on the module: {value}", setting=title, value=text))
        set_role(self.value, "muted" if known is None or known.is_stale else "strong")
        self.how.setText(note)


def _choice_box(command: Command, values: Mapping[str, Value]) -> QComboBox:
    """Make a box of several values; without an edit none is chosen."""
    box = named(QComboBox(), f"{command.name}_wanted", says=tr(command.title), tip=tr(command.explanation))
    for text, value in values.items():
        box.addItem(text, value)
    box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
    box.setCurrentIndex(-1)
    box.setPlaceholderText(tr("choose"))
    WheelGuard(box)
    return box


class SettingRow(QObject):
    """The cells of one setting. The signals of its field are only about what a person did."""

    def __init__(self, table: SettingsTable, command: Command, find_work: Callable[[], SettingsDraft]) -> None:
        super().__init__(table)
        self.command = command
        name, key, title = command.name, command.key, tr(command.title)
        self.name = text_label(f"{name}_name", text=title)
        self.held = HeldValue(command)
        if isinstance(field := command.write, Quantity):
            line = NumberLine(NumberKind.of_field(field), may_be_empty=True)
            named(line, f"{name}_wanted", says=title, tip=tr(command.explanation))
            line.setAccessibleDescription(tr("{low} to {high}", low=field.text(0), high=field.text(255)))

            def take_typed() -> None:
                """Also what is typed so far is an edit; what cannot be sent stays as it was typed."""
                wanted: Value | str | None = line.text() if line.is_wrong else None
                if line.number is not None:
                    wanted = field.decode(round(line.number * field.per_unit))
                find_work().fill({key: wanted})

            line.edited.connect(take_typed)
            self.editor: NumberLine | QComboBox = line
        else:
            box = self.editor = _choice_box(command, {tr("Enabled"): True, tr("Disabled"): False})
            box.activated.connect(lambda: find_work().fill({key: box.currentData()}))
        self.name.setBuddy(self.editor)
        self.picture = IconLabel(f"{name}_state_icon", Size.BODY)
        self.state = named(QLabel(), f"{name}_state")
        self.reason = text_label(f"{name}_reason", "small")
        self.default = control(QToolButton(), f"{name}_default", text=tr("Default"), role="narrow")
        self.default.clicked.connect(lambda: find_work().fill({key: DEFAULTS[key]}))
        self.discard = control(QToolButton(), f"{name}_discard", picture=Icon.DISCARD, role="narrow")
        self.discard.clicked.connect(lambda: find_work().fill({key: None}))
        default = value_text(command, DEFAULTS[key]) if key in DEFAULTS else ""
        texts = ((self.default, tr("Default {value}", value=default)), (self.discard, tr("Discard this edit")))
        for button, text in texts:
            button.setToolTip(text)
            button.setAccessibleName(labelled(title, text))
            if button is self.discard or key in DEFAULTS:
                retain_size(button)  # so that none of them ever takes the other's place
        place = table.add_cells(self.name, self.held, self.editor)
        state = in_row(self.picture, self.state, 1, spacing=Space.XS, margins=0)
        self.buttons = in_row(1, self.default, self.discard, spacing=Space.XS, margins=0)
        if table.is_large:
            table.grid.addLayout(state, place + 1, 0)
            table.grid.addLayout(self.buttons, place + 1, 1, 1, 2)
            table.grid.addWidget(self.reason, place + 2, 0, 1, 3)
        else:
            table.grid.addLayout(state, place, 3)
            table.grid.addWidget(self.reason, place, 4, Qt.AlignmentFlag.AlignVCenter)
            table.grid.addLayout(self.buttons, place, 5)

    def show_row(self, row: SettingDraft, now: float, *, is_editable: bool, last_write: str) -> None:
        self.held.show_known(row.known, now)
        held = None if row.known is None else row.known.value
        stands = held if row.edited is None else row.edited
        role = "muted" if row.edited is None else ""
        if isinstance(self.editor, QComboBox):
            with QSignalBlocker(self.editor):
                self.editor.setCurrentIndex(-1 if row.edited is None else self.editor.findData(row.edited))
            set_role(self.editor, role)
        elif isinstance(row.wanted, str):
            self.editor.show_text(row.wanted)
        elif row.wanted is not None or not self.editor.hasFocus() or self.editor.text().strip():
            # Else the person has emptied it to type another one.
            self.editor.show_number(None if stands is None else float(stands), role)
        default = DEFAULTS.get(self.command.key)
        self.default.setVisible(default is not None and (isinstance(row.wanted, str) or stands != default))
        self.discard.setVisible(row.wanted is not None)
        for widget in (self.editor, self.default, self.discard):
            widget.setEnabled(is_editable)
        is_bad = row.state in (RowState.FAILED, RowState.IMPOSSIBLE)
        is_loud = not is_bad and any(consequence.is_risk for consequence in row.consequences)
        word = tr(row.state.value)
        self.state.setText(word)
        self.state.setAccessibleName(labelled(tr(self.command.title), word))
        style = WARNED if is_loud else STYLES[row.state]
        self.picture.show_icon(style.icon, style.meaning, is_muted=style.meaning is None)
        set_role(self.state, "muted" if style.meaning is None else "")
        # What a value takes away is said for as long as it stands, before why its row is in its state.
        reason = row.reason
        if row.state is RowState.IMPOSSIBLE and isinstance(self.editor, NumberLine):
            reason = self.editor.kind.range_text
        meaning = with_units(join_sentences(consequence.message.translated() for consequence in row.consequences))
        self.reason.setText(meaning if is_loud else reason if is_bad else reason or meaning)
        set_role(self.reason, "danger" if is_bad else "attention" if is_loud else "small")
        tip = (reason, meaning, tr(self.command.explanation), capitalised(advice_text(self.command)), last_write)
        self.held.value.setAccessibleDescription(last_write)
        for cell in (self.name, self.held, self.state, self.reason):
            cell.setToolTip("\n".join(line for line in tip if line))


class BaudRow(QObject):
    """An act of its own, with a confirmation. What came of it is a notice of the port."""

    def __init__(self, table: SettingsTable, services: Services) -> None:
        super().__init__(table)
        self._services, self._ports = services, services.ports
        self.name = text_label("baud_title", text=tr(BAUD_RATE.title))
        self.held = HeldValue(BAUD_RATE)
        field = BAUD_RATE.write
        rates = sorted(field.values.values(), reverse=True) if isinstance(field, Choice) else ()
        self.editor = _choice_box(BAUD_RATE, {tr("{rate} baud", rate=rate): rate for rate in rates})
        self.name.setBuddy(self.editor)
        self.message = text_label("baud_message", "small")
        self.confirm = Confirm("baud", ask=f"{TITLES[Act.CHANGE_BAUD]}…", go=marked("Change now"))
        place = table.add_cells(self.name, self.held, self.editor)
        if table.is_large:
            table.add_below(self.message)
        else:
            table.grid.addWidget(self.message, place, 3, 1, len(_SHARES) - 3, Qt.AlignmentFlag.AlignVCenter)
        table.add_below(self.confirm)
        self.editor.activated.connect(self._choose)
        self.confirm.confirmed.connect(self._change)

    def refresh(self) -> None:
        port = self._ports.current
        self.held.show_known(port.module.view.known(BAUD_RATE.key, port.now_s), port.now_s)
        refusals = open_conditions(self._services, Act.CHANGE_BAUD)
        text = tr("The vendor advises not to change it.")
        if port.is_changing_rate:
            text = tr("Changing the baud rate…")
        elif refusals:
            text = join_sentences(refusal.sentence for refusal in refusals)
        self.message.setText(text)
        set_role(self.message, "attention" if refusals and not port.is_changing_rate else "small")
        is_free = port.module.is_going and not port.is_changing_rate
        self.editor.setEnabled(is_free)
        is_other = self.editor.currentData() not in (None, port.connection.baud_rate)
        self.confirm.set_possible(is_free and not is_blocked(refusals) and is_other)

    def _choose(self) -> None:
        self.confirm.withdraw()
        self.refresh()

    def forget_choice(self) -> None:
        """It was made for the module before."""
        with QSignalBlocker(self.editor):
            self.editor.setCurrentIndex(-1)

    def _change(self) -> None:
        rate = self.editor.currentData()
        self.forget_choice()
        if rate is not None:
            self._ports.current.change_rate(rate, self._services.armed)
