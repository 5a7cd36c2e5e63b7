"""Fields for another value of a setting, and the value that the module holds."""

from collections.abc import Mapping
from typing import Final

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QComboBox, QLabel, QWidget

from app.engine.conversation import How, Known
from app.settings.values import DEFAULTS, value_text
from app.text.i18n import tr
from app.text.messages import duration
from protocol.catalogue import Command
from protocol.fields import Choice, Flag, Quantity, Value
from protocol.translatable import marked
from ui.widgets.controls import TickingLabel, control, in_column, named, set_role
from ui.widgets.number_line import NumberKind, NumberLine, WheelGuard


class NumberEditor(NumberLine):
    """A number; without an edit the module's value, muted. The signals are only about what the user did."""

    chosen = Signal(object)
    """A value, also of what is typed so far."""
    mistyped = Signal(str)
    """What was typed, which cannot be sent."""
    cancelled = Signal()
    """The field was emptied."""

    def __init__(self, command: Command, field: Quantity) -> None:
        start = float(DEFAULTS.get(command.key) or 0)
        super().__init__(NumberKind.of_field(field), start=start, may_be_empty=True)
        self._field = field
        self.setAccessibleDescription(tr("{low} to {high}", low=field.text(0), high=field.text(255)))
        self.edited.connect(self._choose)

    def show_value(self, edited: Value | None, held: Value | None) -> None:
        """The edited value, else the one that the module holds."""
        if edited is None and self.hasFocus() and not self.text().strip():
            return  # the person has emptied it to type another one
        value = held if edited is None else edited
        self.show_number(None if value is None else float(value), "muted" if edited is None else "")

    def show_mistyped(self, text: str) -> None:
        self.show_text(text)

    def _choose(self) -> None:
        number = self.number
        if number is not None:
            self.chosen.emit(self._field.decode(round(number * self._field.per_unit)))
        elif self.is_wrong:
            self.mistyped.emit(self.text())
        else:
            self.cancelled.emit()


class ChoiceEditor(QComboBox):
    """One of several values; without an edit none is chosen."""

    chosen = Signal(object)
    mistyped = Signal(str)
    cancelled = Signal()

    def __init__(self, values: Mapping[str, Value]) -> None:
        super().__init__()
        for text, value in values.items():
            self.addItem(text, value)
        self.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.setCurrentIndex(-1)
        self.setPlaceholderText(tr("choose"))
        WheelGuard(self)
        self.activated.connect(lambda: self.chosen.emit(self.currentData()))

    def show_value(self, edited: Value | None, _held: Value | None) -> None:
        with QSignalBlocker(self):
            self.setCurrentIndex(-1 if edited is None else self.findData(edited))
        set_role(self, "muted" if edited is None else "")

    def show_mistyped(self, text: str) -> None:
        """Nothing can be mistyped here."""


FieldEditor = NumberEditor | ChoiceEditor


def make_editor(command: Command) -> FieldEditor:
    """The field for a command. Raises `LookupError` for one that cannot be set."""
    match command.write:
        case Quantity() as field:
            editor: FieldEditor = NumberEditor(command, field)
        case Flag():
            editor = ChoiceEditor({tr("Enabled"): True, tr("Disabled"): False})
        case Choice() as field:
            rates = sorted(field.values.values(), reverse=True)
            editor = ChoiceEditor({f"{rate} {tr(field.unit)}": rate for rate in rates})
        case _:
            raise LookupError(f"{command.name} cannot be set")
    return control(editor, f"{command.name}_wanted", says=tr(command.title), tip=tr(command.explanation))


# The module's value

HOW_WORDS: Final[Mapping[How, str]] = {
    How.READ: marked("read {time} ago"),
    How.ACKNOWLEDGED: marked("acknowledged {time} ago"),
    How.STREAMED: marked("seen {time} ago"),
}


class HeldValue(QWidget):
    """The value that the module holds of one setting, and below it how that is known."""

    def __init__(self, command: Command) -> None:
        super().__init__()
        self._command = command
        self.value = named(QLabel(), f"{command.name}_stands", "strong")
        self.how = named(TickingLabel(), f"{command.name}_stands_how", "small")
        self.how.setAccessibleName(tr(command.title))
        self.how.setWordWrap(True)
        in_column(self.value, self.how, of=self, spacing=0, margins=0)

    def show_known(self, known: Known | None, now: float) -> None:
        title = tr(self._command.title)
        if known is None:
            text = tr("unknown")
            note = tr("not read yet") if self._command.reads_back else tr("cannot be read")
        else:
            text = value_text(self._command, known.value)
            note = tr(HOW_WORDS[known.how], time=duration(max(0.0, now - known.at)))
        self.value.setText(text)
        self.value.setAccessibleName(tr("{setting} on the module: {value}", setting=title, value=text))
        set_role(self.value, "muted" if known is None or known.is_stale else "strong")
        self.how.setText(note)
