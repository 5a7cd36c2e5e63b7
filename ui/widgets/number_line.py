"""A number as a person types it: nothing is swallowed, clamped, rounded or completed; alone or beside a slider.

What cannot be used stays as it was typed, in red, and whoever shows the field says the range beside it. A spin box
cannot do that: it refuses a key that leads out of its range, so that 650 becomes 65.
"""

import re
from decimal import Decimal
from typing import Final, NamedTuple, Self

from PySide6.QtCore import QEvent, QObject, QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QLabel, QLineEdit, QSlider, QWidget

from app.text.i18n import tr
from protocol.fields import Quantity
from ui.style.theme import Space, scaled
from ui.widgets.controls import in_row, named, set_role, text_label

# What an input method writes, as ASCII.
_HALF_WIDTH: Final = {0xFF01 + code: 0x21 + code for code in range(94)} | {ord("。"): "."}
_PLAIN: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)", re.ASCII)


class NumberKind(NamedTuple):
    """The numbers that may be used: from `low` to `high`, in steps of `step` from zero."""

    low: Decimal
    high: Decimal
    step: Decimal
    unit: str
    decimals: int

    @classmethod
    def of(cls, low: float, high: float, step: float, unit: str, decimals: int) -> Self:
        return cls(Decimal(str(low)), Decimal(str(high)), Decimal(str(step)), unit, decimals)

    @classmethod
    def of_field(cls, field: Quantity) -> Self:
        """Return the kind of what a byte of the module can carry."""
        step = Decimal(1) / field.per_unit
        return cls(Decimal(0), 255 * step, step, field.unit, field.decimals)

    def read(self, text: str) -> float | None:
        """The number that was typed; None where it cannot be used. A comma counts as a decimal point, and the unit may
        be typed, too."""
        plain = text.translate(_HALF_WIDTH).strip().removesuffix(self.unit).rstrip().replace(",", ".")
        if len(plain) > 32 or not _PLAIN.fullmatch(plain):
            return None
        number = Decimal(plain)
        return float(number) if self.low <= number <= self.high and not number % self.step else None

    def shown(self, number: float) -> str:
        """Return the number without the unit."""
        return f"{number:.{self.decimals}f}"

    def with_unit(self, number: float | Decimal) -> str:
        gap = "" if self.unit in ("°", "") else " "
        return f"{self.shown(float(number))}{gap}{self.unit}"

    @property
    def range_text(self) -> str:
        """The range that may be typed, in the language in use."""
        low, high, step = (self.with_unit(number) for number in (self.low, self.high, self.step))
        return tr("{low} to {high}, in steps of {step}", low=low, high=high, step=step)


class NumberLine(QLineEdit):
    """An empty field is right if it `may_be_empty`."""

    edited = Signal()  # The person typed; not told of what the program shows

    def __init__(self, kind: NumberKind, *, may_be_empty: bool = False) -> None:
        super().__init__()
        self.kind, self._may_be_empty = kind, may_be_empty
        self._role = ""
        self.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.setAcceptDrops(False)
        self.textEdited.connect(self._on_edit)

    @property
    def number(self) -> float | None:
        """The number in the field; None where it cannot be used, or is empty."""
        return self.kind.read(self.text())

    @property
    def is_wrong(self) -> bool:
        return self.number is None and not (self._may_be_empty and not self.text().strip())

    def show_number(self, number: float | None, role: str = "") -> None:
        """Shows it in its usual form, unless it stands there already: what is being typed is never completed."""
        if number is None:
            self.clear()
        elif self.number != number:
            self.setText(self.kind.shown(number))
        self._role = role
        self._mark()

    def show_text(self, text: str) -> None:
        """Shows what a person had typed."""
        if self.text() != text:
            self.setText(text)
        self._mark()

    def _on_edit(self) -> None:
        self._role = ""
        self._mark()
        self.edited.emit()

    def _mark(self) -> None:
        set_role(self, "wrong" if self.is_wrong else self._role)


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

    A number that cannot be used stays as it was typed; `value` and the slider stay as before. Whoever shows the dial
    gives `range`, which stands only then, a place of its own: beside the slider it would take the room from it.
    """

    turned = Signal(float)
    judged = Signal()  # Something was typed; whether it can be used is `is_wrong`

    def __init__(self, name: str, kind: NumberKind) -> None:
        super().__init__()
        self.setObjectName(name)
        self._step, self.value = float(kind.step), float(kind.low)
        self.slider = named(QSlider(Qt.Orientation.Horizontal), f"{name}_slider")
        self.slider.setRange(round(kind.low / kind.step), round(kind.high / kind.step))
        WheelGuard(self.slider)
        self.box = named(NumberLine(kind), f"{name}_box")
        self.box.setFixedWidth(scaled(72))  # less than Qt's hint, since the unit stands beside it
        self.unit = named(QLabel(kind.unit), f"{name}_unit", "muted")
        self.range = text_label(f"{name}_range", "danger")
        self.range.hide()
        in_row((self.slider, 1), self.box, self.unit, of=self, spacing=Space.S, margins=0)
        self.setFocusProxy(self.slider)
        self.slider.valueChanged.connect(self._on_step)
        self.box.edited.connect(self._typed)
        self.box.show_number(self.value)

    def describe(self, title: str, explanation: str) -> None:
        for widget in (self.slider, self.box):
            named(widget, widget.objectName(), says=title, tip=explanation)

    @property
    def is_wrong(self) -> bool:
        return self.box.is_wrong

    def show_value(self, value: float) -> None:
        """Shows the module's value, unless the user is changing it."""
        if not (self.slider.isSliderDown() or self.box.hasFocus()):
            self.set_value(value)

    def set_value(self, value: float) -> None:
        """In any case, but what is typed and cannot be used stays until there is another value."""
        if self.is_wrong and value == self.value:
            return
        self.value = value
        with QSignalBlocker(self.slider):
            self.slider.setValue(round(value / self._step))
        self.box.show_number(value)
        self._show_range()

    def _on_step(self, steps: int) -> None:
        self.set_value(round(steps * self._step, self.box.kind.decimals))
        self.turned.emit(self.value)

    def _typed(self) -> None:
        self._show_range()
        number = self.box.number
        if number is not None and number != self.value:
            self.set_value(number)
            self.turned.emit(number)
        self.judged.emit()

    def _show_range(self) -> None:
        self.range.setText(self.box.kind.range_text if self.is_wrong else "")
        self.range.setVisible(self.is_wrong)
