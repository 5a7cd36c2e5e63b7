"""Sliders with a number field, and the guard against accidental wheel events."""

from PySide6.QtCore import QEvent, QObject, QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QDoubleSpinBox, QLabel, QSlider, QWidget

from ui.core.texts import Texts
from ui.style.theme import Space, scaled
from ui.widgets.controls import control, named
from ui.widgets.layouts import in_row
from ui.widgets.visibility_timer import VisibilityTimer

NUMBER_PX = 104
"""Width of a number box with its unit, smaller than Qt's size hint."""


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


def fit_number(box: QWidget) -> None:
    """Gives a number box its width in the size of text in use."""

    def fit() -> None:
        box.setFixedWidth(scaled(NUMBER_PX))

    VisibilityTimer(box, fit, restyle=fit)
    fit()


def label_for(texts: Texts, widget: QWidget, title: str) -> QLabel:
    label = control(QLabel(), texts, f"{widget.objectName()}_label", title)
    label.setBuddy(widget)
    label.setMinimumHeight(widget.sizeHint().height())  # aligns its text with that of the field
    return label


class Dial(QWidget):
    """A slider and a number box for one value; `turned` is emitted only for changes by the user."""

    turned = Signal(float)

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
        self._step = step
        if decimals is None:
            decimals = 0 if step >= 1 else 2
        self.slider = named(QSlider(Qt.Orientation.Horizontal), f"{name}_slider")
        self.slider.setRange(round(minimum / step), round(maximum / step))
        self.box = named(QDoubleSpinBox(), f"{name}_box")
        self.box.setDecimals(decimals)
        self.box.setRange(minimum, maximum)
        self.box.setSingleStep(step)
        self.box.setSuffix(unit)
        self.box.setKeyboardTracking(False)
        self.box.setAlignment(Qt.AlignmentFlag.AlignRight)
        fit_number(self.box)
        for widget in (self.slider, self.box):
            WheelGuard(widget)
        in_row((self.slider, 1), self.box, of=self, spacing=Space.S, margins=0)
        self.setFocusProxy(self.slider)
        self.slider.valueChanged.connect(self._on_step)
        self.box.valueChanged.connect(self._typed)

    def describe(self, texts: Texts, title: str, explanation: str) -> None:
        for widget in (self.slider, self.box):
            control(widget, texts, widget.objectName(), says=title, tip=explanation)

    @property
    def value(self) -> float:
        return self.box.value()

    def show_value(self, value: float) -> None:
        """Shows the module's value, unless the user is changing it."""
        if not (self.slider.isSliderDown() or self.box.hasFocus()):
            self.set_value(value)

    def set_value(self, value: float) -> None:
        """In any case."""
        with QSignalBlocker(self.slider), QSignalBlocker(self.box):
            self.slider.setValue(round(value / self._step))
            self.box.setValue(value)

    def _on_step(self, steps: int) -> None:
        value = steps * self._step
        with QSignalBlocker(self.box):
            self.box.setValue(value)
        self.turned.emit(value)

    def _typed(self, value: float) -> None:
        with QSignalBlocker(self.slider):
            self.slider.setValue(round(value / self._step))
        self.turned.emit(value)
