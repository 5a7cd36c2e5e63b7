"""Editors for numbers, flags and choices."""

from abc import abstractmethod
from collections.abc import Callable
from functools import partial
from typing import Final

from PySide6.QtCore import QEvent, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QIcon, QKeyEvent, QValidator
from PySide6.QtWidgets import QComboBox, QDoubleSpinBox, QLabel, QSizePolicy, QToolButton, QWidget

from app.settings.drafts import Draft
from app.settings.setting_texts import DEFAULTS, plain_text
from app.text.i18n import tr
from protocol.catalogue import Command
from protocol.fields import Choice, Flag, Quantity, Value
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.style.icons import Icon, icon, set_icon_size
from ui.style.theme import Space
from ui.widgets.controls import ChoiceButton, control, named
from ui.widgets.layouts import in_row
from ui.widgets.sliders import NUMBER_PX, WheelGuard

_FLAG_PX: Final = 92


class FieldEditor(QWidget):
    """Shows a draft; the signals are only about what the user did."""

    typed = Signal(str)
    """The text typed so far."""
    chosen = Signal(object)
    """A complete value."""
    left = Signal()
    """The user left the editor: further changes are another undo step."""

    @abstractmethod
    def show_draft(self, draft: Draft | None, stands: Value | None) -> None:
        """Shows the edited value; `stands` is the module's."""


class NumberEditor(FieldEditor):
    """A number with its unit. Arrow and page keys, its buttons and, with the focus, the wheel change it in steps."""

    def __init__(self, command: Command, field: Quantity, texts: Texts, guard: WheelGuard) -> None:
        super().__init__()
        self._command, self._field = command, field
        self._draft: Draft | None = None
        self._stands: Value | None = None
        self.box = control(_NumberBox(field, self.step), texts, f"{command.name}_number", says=command.title,
                           tip=command.explanation)  # fmt: skip
        guard.guard(self.box)
        self.line = named(self.box.lineEdit(), f"{command.name}_wanted")
        texts.bind(self.line.setAccessibleName, command.title)
        limits = {"low": field.text(0), "high": field.text(255)}
        texts.bind(self.box.setAccessibleDescription, "{low} to {high}", **limits)
        unit = named(QLabel(field.unit), f"{command.name}_unit", "muted")
        unit.setMinimumWidth(14)
        in_row(self.box, unit, 1, of=self, spacing=Space.XS, margins=0)
        self.setFocusProxy(self.box)
        self.line.textEdited.connect(self.typed)
        self.box.editingFinished.connect(self.left)

    def show_draft(self, draft: Draft | None, stands: Value | None) -> None:
        self._draft, self._stands = draft, stands
        self.line.setPlaceholderText("" if stands is None else plain_text(self._command, stands))
        text = "" if draft is None else draft.text
        with QSignalBlocker(self.line), QSignalBlocker(self.box):
            if self.line.text() != text and not (self.box.hasFocus() and self.line.text().strip() == text):
                self.line.setText(text)
            number = stands if draft is None or draft.value is None else draft.value
            self.box.setValue(0.0 if number is None else float(number))

    def step(self, steps: int) -> None:
        """Steps from the edited value, else from the module's, else from the default."""
        start = self._stands if self._draft is None or self._draft.value is None else self._draft.value
        if start is None:
            start = DEFAULTS.get(self._command.key)
        raw = 0 if start is None else min(255, max(0, self._field.encode(start) + steps))
        self.chosen.emit(self._field.decode(raw))


class _NumberBox(QDoubleSpinBox):
    """Keeps whatever is typed, also if it is not a number: the form says why, and nothing is written. The value, for
    screen readers, is the edited one, else the module's."""

    def __init__(self, field: Quantity, step: Callable[[int], None]) -> None:
        super().__init__()
        self._step = step
        self.setDecimals(field.decimals)
        self.setRange(0.0, field.maximum)
        self.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.setFixedWidth(NUMBER_PX)
        self.setAcceptDrops(False)
        self.lineEdit().setMaxLength(32)
        self.lineEdit().setAcceptDrops(False)

    def validate(self, text: str, position: int) -> tuple[QValidator.State, str, int]:
        return QValidator.State.Acceptable, text, position

    def valueFromText(self, _text: str) -> float:
        return self.value()

    def textFromValue(self, _value: float) -> str:
        return self.lineEdit().text()

    def stepEnabled(self) -> QDoubleSpinBox.StepEnabledFlag:
        return QDoubleSpinBox.StepEnabledFlag.StepUpEnabled | QDoubleSpinBox.StepEnabledFlag.StepDownEnabled

    def stepBy(self, steps: int) -> None:
        self._step(steps)

    def event(self, event: QEvent) -> bool:
        # Undo and redo belong to the form, not to the line edit.
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            has_control = event.modifiers() & Qt.KeyboardModifier.ControlModifier
            if has_control and event.key() in (Qt.Key.Key_Z, Qt.Key.Key_Y):
                event.ignore()
                return False
        return super().event(event)


class FlagEditor(FieldEditor):
    """Two buttons, Enabled and Disabled; the edited value is checked, and clicking it again removes the edit."""

    cancelled = Signal()

    def __init__(self, command: Command, texts: Texts) -> None:
        super().__init__()
        self.on = self._button(texts, command, "on", marked("Enabled"))
        self.off = self._button(texts, command, "off", marked("Disabled"))
        in_row((self.on, 1), (self.off, 1), of=self, spacing=Space.XS, margins=0)
        self.setFocusProxy(self.on)
        self.on.clicked.connect(lambda is_down: self._choose(True if is_down else None))
        self.off.clicked.connect(lambda is_down: self._choose(False if is_down else None))

    def show_draft(self, draft: Draft | None, _stands: Value | None) -> None:
        wanted = None if draft is None else draft.value
        for button, value in ((self.on, True), (self.off, False)):
            with QSignalBlocker(button):
                button.setChecked(wanted is value)
            button.setIcon(icon(Icon.CHECK) if wanted is value else QIcon())

    def _choose(self, value: bool | None) -> None:
        if value is None:
            self.cancelled.emit()
        else:
            self.chosen.emit(value)

    def _button(self, texts: Texts, command: Command, name: str, english: str) -> QToolButton:
        button = control(ChoiceButton(), texts, f"{command.name}_{name}", english, tip=command.explanation,
                         role="choice", is_checkable=True)  # fmt: skip
        button.setMinimumWidth(_FLAG_PX)
        button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        set_icon_size(button, 14)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        texts.bind(partial(_name_after, button, command), english)
        return button


class ChoiceEditor(FieldEditor):
    """A combo box; nothing is chosen at first."""

    def __init__(self, command: Command, field: Choice, texts: Texts, guard: WheelGuard) -> None:
        super().__init__()
        self.box = control(QComboBox(), texts, f"{command.name}_wanted", says=command.title, tip=command.explanation)
        for number, value in enumerate(sorted(field.values.values(), reverse=True)):
            self.box.addItem("", value)
            texts.bind(partial(self._name_item, number, value), field.unit)
        self.box.setCurrentIndex(-1)
        texts.bind(self.box.setPlaceholderText, "choose")
        guard.guard(self.box)
        in_row(self.box, of=self, margins=0)
        self.setFocusProxy(self.box)
        self.box.activated.connect(lambda: self.chosen.emit(self.value))

    def _name_item(self, number: int, value: int, unit: str) -> None:
        self.box.setItemText(number, f"{value} {unit}")

    @property
    def value(self) -> int | None:
        data = self.box.currentData()
        return None if data is None else int(data)

    def show_draft(self, draft: Draft | None, _stands: Value | None) -> None:
        wanted = None if draft is None else draft.value
        with QSignalBlocker(self.box):
            self.box.setCurrentIndex(-1 if wanted is None else self.box.findData(wanted))


def _name_after(button: QToolButton, command: Command, what: str) -> None:
    """Adds the setting to the name, since screen readers do not tell the row."""
    button.setAccessibleName(tr("{setting}: {what}", setting=tr(command.title), what=what))


def make_editor(command: Command, texts: Texts, guard: WheelGuard) -> FieldEditor:
    """The editor for a command. Raises `LookupError` for one that cannot be set."""
    match command.write:
        case Quantity() as field:
            return NumberEditor(command, field, texts, guard)
        case Flag():
            return FlagEditor(command, texts)
        case Choice() as field:
            return ChoiceEditor(command, field, texts, guard)
        case _:
            raise LookupError(f"{command.name} cannot be set")
