"""Fields of the form and of the profile editor: captions, an optional number, a manual check."""

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QCheckBox, QDoubleSpinBox, QGridLayout, QLabel, QLineEdit, QToolButton, QWidget

from app.settings.profiles import MAX_NAME_LENGTH, ManualLine
from app.text.i18n import tr
from ui.core.texts import Texts
from ui.style.icons import Icon
from ui.style.theme import Space
from ui.widgets.controls import control, named
from ui.widgets.layouts import in_row
from ui.widgets.sliders import WheelGuard

_DECIMALS = 4
_NUMBER_PX = 120


def captioned_row(texts: Texts, *fields: tuple[str, QWidget]) -> QGridLayout:
    """Fields of equal width in a row, each below its caption (English, marked)."""
    grid = QGridLayout()
    grid.setContentsMargins(0, 0, 0, 0)
    grid.setHorizontalSpacing(Space.S)
    grid.setVerticalSpacing(2)
    for column, (caption, field) in enumerate(fields):
        label = control(QLabel(), texts, f"{field.objectName()}_caption", caption, role="small")
        label.setBuddy(field)
        grid.addWidget(label, 0, column)
        grid.addWidget(field, 1, column)
        grid.setColumnStretch(column, 1)
    return grid


class _Number(QDoubleSpinBox):
    """Shows no trailing zeros."""

    def textFromValue(self, value: float) -> str:
        return f"{value:g}"


class OptionalNumber(QWidget):
    """A number with a check box; `value` is None while it is not checked."""

    changed = Signal()

    def __init__(
        self, name: str, default: float, low: float, high: float, *, unit: str = "", guard: WheelGuard
    ) -> None:
        super().__init__()
        self.setObjectName(name)
        self._default = default
        self.tick = named(QCheckBox(), f"{name}_tick")
        self.box = named(_Number(), f"{name}_value")
        self.box.setDecimals(_DECIMALS)
        self.box.setRange(low, high)
        self.box.setSingleStep(0.1 if high <= 5 and default % 1 else 1)
        self.box.setSuffix(unit)
        self.box.setFixedWidth(_NUMBER_PX)
        self.box.setAlignment(Qt.AlignmentFlag.AlignRight)
        guard.guard(self.box)
        self.tick.toggled.connect(self._on_tick)
        self.box.valueChanged.connect(self.changed)
        in_row((self.tick, 1), self.box, of=self, spacing=Space.S, margins=0)
        self.show_value(None)

    @property
    def value(self) -> float | int | None:
        if not self.tick.isChecked():
            return None
        value = round(self.box.value(), _DECIMALS)
        return int(value) if value.is_integer() else value

    def show_value(self, value: float | None) -> None:
        with QSignalBlocker(self.tick), QSignalBlocker(self.box):
            self.tick.setChecked(value is not None)
            self.box.setValue(self._default if value is None else value)
        self.box.setEnabled(value is not None)

    def show_title(self, title: str, why: str) -> None:
        self.tick.setText(title)
        self.tick.setToolTip(why)
        self.tick.setAccessibleName(title)
        self.box.setAccessibleName(title)
        self.box.setToolTip(why)

    def _on_tick(self, is_on: bool) -> None:
        self.box.setEnabled(is_on)
        if not is_on:
            with QSignalBlocker(self.box):
                self.box.setValue(self._default)
        self.changed.emit()


class ManualEditor(QWidget):
    """One manual check: its text, and whether it may be skipped."""

    changed = Signal()
    removed = Signal()

    def __init__(self, number: int, line: ManualLine, texts: Texts) -> None:
        super().__init__()
        name = f"profile_manual_{number}"
        self.setObjectName(name)
        self.number = number
        self.text = named(QLineEdit(line.text), f"{name}_text")
        self.text.setMaxLength(MAX_NAME_LENGTH)
        self.required = control(QCheckBox(), texts, f"{name}_required", "Required")
        self.required.setChecked(line.is_required)
        self.remove = control(QToolButton(), texts, f"{name}_remove", says="Remove", tip="Remove", picture=Icon.CROSS,
                              role="quiet", slot=self.removed)  # fmt: skip
        self.text.textEdited.connect(self.changed)
        self.required.toggled.connect(self.changed)
        in_row((self.text, 1), self.required, self.remove, of=self, spacing=Space.S, margins=0)
        self.show_texts()

    @property
    def line(self) -> ManualLine:
        return ManualLine(self.text.text().strip(), self.required.isChecked())

    def show_texts(self) -> None:
        self.text.setAccessibleName(f"{tr('Manual checks')} {self.number}")
        self.text.setPlaceholderText(tr("Manual checks"))
