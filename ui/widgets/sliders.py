"""Sliders with a number field, and the guard against accidental wheel events."""

from PySide6.QtCore import QEvent, QObject, QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QLabel, QSlider, QWidget

from ui.style.theme import Space, scaled
from ui.widgets.controls import control, named
from ui.widgets.layouts import in_row
from ui.widgets.number_line import NumberKind, NumberLine

_BARE_NUMBER_PX = 72
"""Width of a number whose unit stands beside it, smaller than Qt's size hint."""


class WheelGuard(QObject):
    """Lets the wheel change the value of `widget` only while it has the focus; else it scrolls."""

    def __init__(self, widget: QWidget) -> None:
        super().__init__(widget)
        widget.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        widget.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Wheel and isinstance(watched, QWidget) and not watched.hasFocus():
            event.ignore()  # passes it on to the scroll area
            return True
        return False


def label_for(widget: QWidget, title: str) -> QLabel:
    label = named(QLabel(title), f"{widget.objectName()}_label")
    label.setBuddy(widget)
    label.setMinimumHeight(widget.sizeHint().height())  # aligns its text with that of the field
    return label


class Dial(QWidget):
    """A slider and a number for one value; `turned` is emitted only for changes by the user.

    A number that cannot be used stays as it was typed, with the range beside it; `value` and the slider stay as before.
    """

    turned = Signal(float)
    judged = Signal()
    """Something was typed; whether it can be used is `is_wrong`."""

    def __init__(
        self,
        name: str,
        *,
        minimum: float,
        maximum: float,
        step: float,
        unit: str,
        decimals: int | None = None,
    ) -> None:
        super().__init__()
        self.setObjectName(name)
        self._step, self._value = step, minimum
        if decimals is None:
            decimals = 0 if step >= 1 else 2
        self.slider = named(QSlider(Qt.Orientation.Horizontal), f"{name}_slider")
        self.slider.setRange(round(minimum / step), round(maximum / step))
        kind = NumberKind.of(minimum, maximum, step, unit.strip(), decimals)
        self.box = named(NumberLine(kind, start=minimum), f"{name}_box")
        self.unit = named(QLabel(kind.unit), f"{name}_unit", "muted")
        self.range = named(QLabel(), f"{name}_range", "danger")
        self.range.hide()
        self.box.setFixedWidth(scaled(_BARE_NUMBER_PX))
        WheelGuard(self.slider)
        in_row((self.slider, 1), self.range, self.box, self.unit, of=self, spacing=Space.S, margins=0)
        self.setFocusProxy(self.slider)
        self.slider.valueChanged.connect(self._on_step)
        self.box.edited.connect(self._typed)
        self.box.show_number(minimum)

    def describe(self, title: str, explanation: str) -> None:
        for widget in (self.slider, self.box):
            control(widget, widget.objectName(), says=title, tip=explanation)

    @property
    def value(self) -> float:
        return self._value

    @property
    def is_wrong(self) -> bool:
        """What is typed cannot be used."""
        return self.box.is_wrong

    def show_value(self, value: float) -> None:
        """Shows the module's value, unless the user is changing it."""
        if not (self.slider.isSliderDown() or self.box.hasFocus()):
            self.set_value(value)

    def set_value(self, value: float) -> None:
        """In any case, but what is typed and cannot be used stays until there is another value."""
        if self.is_wrong and value == self._value:
            return
        self._value = value
        with QSignalBlocker(self.slider):
            self.slider.setValue(round(value / self._step))
        self.box.show_number(value)
        self._show_range()

    def _on_step(self, steps: int) -> None:
        self.set_value(round(steps * self._step, self.box.kind.decimals))
        self.turned.emit(self._value)

    def _typed(self) -> None:
        self._show_range()
        number = self.box.number
        if number is not None and number != self._value:
            self.set_value(number)
            self.turned.emit(number)
        self.judged.emit()

    def _show_range(self) -> None:
        self.range.setText(self.box.kind.range_text if self.is_wrong else "")
        self.range.setVisible(self.is_wrong)
