"""The value of a setting as the module has it, with its source and age; editors for numbers, flags and choices."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import Final

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QFontMetricsF, QIcon
from PySide6.QtWidgets import QComboBox, QLabel, QSizePolicy, QToolButton, QWidget

from app.engine.device import How, Known, StaleReason
from app.settings.values import DEFAULTS, value_text, what_is
from app.text.durations import duration
from app.text.i18n import tr
from app.text.sentences import in_brackets, labelled
from protocol.catalogue import Command
from protocol.fields import Choice, Flag, Quantity, Value
from protocol.translatable import marked
from ui.style.icons import Icon, icon, set_icon_size
from ui.style.painted_widget import Freshness
from ui.style.theme import Size, Space, font, scaled
from ui.widgets.controls import ChoiceButton, control, named
from ui.widgets.layouts import in_row
from ui.widgets.number_line import NumberKind, NumberLine
from ui.widgets.readout import Readout
from ui.widgets.sliders import NUMBER_PX, WheelGuard

_FLAG_PX: Final = 92


class FieldEditor(QWidget):
    """Shows an edited value; the signals are only about what the user did."""

    chosen = Signal(object)
    """A value, also of what is typed so far."""

    @abstractmethod
    def show_value(self, edited: Value | None, module_value: Value | None) -> None:
        """Shows the edited value; without one `module_value`."""


class NumberEditor(FieldEditor):
    """A number with its unit; without an edit the module's value, muted."""

    mistyped = Signal(str)
    """What was typed, which cannot be sent."""
    cancelled = Signal()
    """The field was emptied."""

    def __init__(self, command: Command, field: Quantity) -> None:
        super().__init__()
        kind = NumberKind.of_field(field)
        start = float(DEFAULTS.get(command.key) or 0)
        self.line = control(
            NumberLine(kind, start=start, may_be_empty=True),
            f"{command.name}_wanted",
            says=tr(command.title),
            tip=tr(command.explanation),
        )
        self.line.setFixedWidth(NUMBER_PX)
        limits = {"low": field.text(0), "high": field.text(255)}
        self.line.setAccessibleDescription(tr("{low} to {high}", **limits))
        unit = named(QLabel(field.unit), f"{command.name}_unit", "muted")
        unit.setMinimumWidth(14)
        in_row(self.line, unit, 1, of=self, spacing=Space.XS, margins=0)
        self.setFocusProxy(self.line)
        self.line.edited.connect(self._choose)
        self._field = field

    def show_value(self, edited: Value | None, module_value: Value | None) -> None:
        if edited is None and self.line.hasFocus() and not self.line.text():
            return  # the person has emptied it to type another one
        value = module_value if edited is None else edited
        self.line.show_number(None if value is None else float(value), "muted" if edited is None else "")

    def show_mistyped(self, text: str) -> None:
        self.line.show_text(text)

    def _choose(self) -> None:
        number = self.line.number
        if number is not None:
            self.chosen.emit(self._field.decode(round(number * self._field.per_unit)))
        elif self.line.is_wrong:
            self.mistyped.emit(self.line.text())
        else:
            self.cancelled.emit()


class FlagEditor(FieldEditor):
    """Two buttons, Enabled and Disabled; the edited value is checked, and clicking it again removes the edit."""

    cancelled = Signal()

    def __init__(self, command: Command) -> None:
        super().__init__()
        self.on = self._button(command, "on", tr("Enabled"))
        self.off = self._button(command, "off", tr("Disabled"))
        in_row((self.on, 1), (self.off, 1), of=self, spacing=Space.XS, margins=0)
        self.setFocusProxy(self.on)
        self.on.clicked.connect(lambda is_down: self._choose(True if is_down else None))
        self.off.clicked.connect(lambda is_down: self._choose(False if is_down else None))

    def show_value(self, edited: Value | None, _module_value: Value | None) -> None:
        for button, value in ((self.on, True), (self.off, False)):
            with QSignalBlocker(button):
                button.setChecked(edited is value)
            button.setIcon(icon(Icon.CHECK) if edited is value else QIcon())

    def _choose(self, value: bool | None) -> None:
        if value is None:
            self.cancelled.emit()
        else:
            self.chosen.emit(value)

    def _button(self, command: Command, name: str, text: str) -> QToolButton:
        button = control(
            ChoiceButton(),
            f"{command.name}_{name}",
            text=text,
            tip=tr(command.explanation),
            role="choice",
            is_checkable=True,
        )
        button.setMinimumWidth(_FLAG_PX)
        button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        set_icon_size(button, 14)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        # With the setting, since screen readers do not tell the row.
        button.setAccessibleName(labelled(tr(command.title), text))
        return button


class ChoiceEditor(FieldEditor):
    """A combo box; nothing is chosen at first."""

    def __init__(self, command: Command, field: Choice) -> None:
        super().__init__()
        self.box = control(QComboBox(), f"{command.name}_wanted", says=tr(command.title), tip=tr(command.explanation))
        for value in sorted(field.values.values(), reverse=True):
            self.box.addItem(f"{value} {tr(field.unit)}", value)
        self.box.setCurrentIndex(-1)
        self.box.setPlaceholderText(tr("choose"))
        WheelGuard(self.box)
        in_row(self.box, of=self, margins=0)
        self.setFocusProxy(self.box)
        self.box.activated.connect(lambda: self.chosen.emit(self.value))

    @property
    def value(self) -> int | None:
        data = self.box.currentData()
        return None if data is None else int(data)

    def show_value(self, edited: Value | None, _module_value: Value | None) -> None:
        with QSignalBlocker(self.box):
            self.box.setCurrentIndex(-1 if edited is None else self.box.findData(edited))


def explain_setting(widget: QWidget, command: Command) -> None:
    """Sets the "What's this?" text of a setting: term, code, explanation, range, default and advice."""
    widget.setWhatsThis(what_is(command))


def make_editor(command: Command) -> FieldEditor:
    """The editor for a command. Raises `LookupError` for one that cannot be set."""
    match command.write:
        case Quantity() as field:
            return NumberEditor(command, field)
        case Flag():
            return FlagEditor(command)
        case Choice() as field:
            return ChoiceEditor(command, field)
        case _:
            raise LookupError(f"{command.name} cannot be set")


VALUE_PX: Final = 136

HOW_WORDS: Final[Mapping[How, str]] = {
    How.READ: marked("read {time} ago"),
    How.ACKNOWLEDGED: marked("acknowledged {time} ago"),
    How.STREAMED: marked("seen {time} ago"),
}
STALE_WORDS: Final[Mapping[StaleReason, str]] = {
    StaleReason.RESTARTED: marked("before the restart"),
    StaleReason.LINK_LOST: marked("before link loss"),
    StaleReason.WRITE_UNCONFIRMED: marked("before an unconfirmed write"),
    StaleReason.AGED: marked("too old"),
    StaleReason.LATE: marked("late"),
    StaleReason.CONTRADICTED: marked("before contradictory answers"),
}


def how_known(known: Known, now: float) -> str:
    """Source, age and doubt in the language in use: "read 12 s ago (too old)"; its end may be elided."""
    text = tr(HOW_WORDS[known.how], time=duration(max(0.0, now - known.at)))
    return text if known.stale_reason is None else text + in_brackets(tr(STALE_WORDS[known.stale_reason]))


class ValueLabel(Readout):
    """Shows the module's value of one setting, without a caption."""

    def __init__(self, command: Command) -> None:
        self._command = command
        super().__init__("", size=Size.BODY)
        self.setObjectName(f"{command.name}_stands")
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.show_known(None, 0.0)

    def show_known(self, known: Known | None, now: float) -> None:
        if known is None:
            freshness, text = Freshness.UNKNOWN, tr("unknown")
            note = tr("not read yet") if self._command.reads_back else tr("cannot be read")
        else:
            freshness = Freshness.STALE if known.is_stale else Freshness.FRESH
            text, note = value_text(self._command, known.value), how_known(known, now)
        self.show_value(text, freshness=freshness, note=note)

    def _changed(self) -> None:
        name = tr("{setting} on the module: {value}", setting=tr(self._command.title), value=self.text)
        self.setToolTip(self.note)
        self.announce(f"{name}, {self.note}" if self.note else name, name=name)

    def sizeHint(self) -> QSize:
        lines = QFontMetricsF(font(Size.BODY, is_bold=True)), QFontMetricsF(font(Size.SMALL))
        return QSize(scaled(VALUE_PX), round(sum(line.height() for line in lines)))

    def minimumSizeHint(self) -> QSize:
        return QSize(VALUE_PX, self.sizeHint().height())
