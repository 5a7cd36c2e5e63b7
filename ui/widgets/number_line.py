"""A number as a person types it: nothing is swallowed, clamped, rounded or completed.

What cannot be used stays as it was typed, in red, and whoever shows the field says the range beside it. A spin box
cannot do that: it refuses a key that leads out of its range, so that 650 becomes 65.
"""

import re
from decimal import Decimal
from typing import Final, NamedTuple, Self

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QLineEdit

from app.text.i18n import tr
from protocol.fields import Quantity
from ui.widgets.controls import set_role

_HALF_WIDTH: Final = {0xFF01 + code: 0x21 + code for code in range(94)} | {ord("。"): "."}
"""What an input method writes, as ASCII."""
_PLAIN: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)", re.ASCII)
_LONGEST: Final = 32
_PAGE: Final = 10
"""Steps of Page Up and Page Down."""
_STEPS: Final = {Qt.Key.Key_Up: 1, Qt.Key.Key_Down: -1, Qt.Key.Key_PageUp: _PAGE, Qt.Key.Key_PageDown: -_PAGE}


class NumberKind(NamedTuple):
    """The numbers that may be used: from `low` to `high`, in steps of `step` from zero.

    Without `decimals` a number is shown without trailing zeros, and the step is too fine to be worth a word.
    """

    low: Decimal
    high: Decimal
    step: Decimal
    unit: str = ""
    decimals: int | None = None

    @classmethod
    def of(cls, low: float, high: float, step: float, unit: str = "", decimals: int | None = None) -> Self:
        return cls(Decimal(str(low)), Decimal(str(high)), Decimal(str(step)), unit, decimals)

    @classmethod
    def of_field(cls, field: Quantity) -> Self:
        """What a byte of the module can carry."""
        step = Decimal(1) / field.per_unit
        return cls(Decimal(0), 255 * step, step, field.unit, field.decimals)

    def read(self, text: str) -> float | None:
        """The number that was typed; None where it cannot be used. A comma counts as a decimal point, and the unit may
        be typed, too."""
        plain = text.translate(_HALF_WIDTH).strip().removesuffix(self.unit).rstrip().replace(",", ".")
        if len(plain) > _LONGEST or not _PLAIN.fullmatch(plain):
            return None
        number = Decimal(plain)
        if not self.low <= number <= self.high or number % self.step:
            return None
        return float(number)

    def shown(self, number: float) -> str:
        """Without the unit."""
        return f"{number:g}" if self.decimals is None else f"{number:.{self.decimals}f}"

    def with_unit(self, number: float | Decimal) -> str:
        gap = "" if self.unit in ("°", "") else " "
        return f"{self.shown(float(number))}{gap}{self.unit}"

    @property
    def range_text(self) -> str:
        """What may be typed, in the language in use."""
        low, high, step = (self.with_unit(number) for number in (self.low, self.high, self.step))
        if self.decimals is None:
            return tr("{low} to {high}", low=low, high=high)
        return tr("{low} to {high}, in steps of {step}", low=low, high=high, step=step)

    def stepped(self, number: float, steps: int) -> float:
        """The next number upwards or downwards, within the range."""
        wanted = Decimal(str(number)) + steps * self.step
        return float(min(self.high, max(self.low, wanted)))


class NumberLine(QLineEdit):
    """`start` is where the arrow keys begin in an empty field, which is right if `may_be_empty`."""

    edited = Signal()
    """The person typed or stepped; not told of what the program shows."""

    def __init__(self, kind: NumberKind, *, start: float = 0.0, may_be_empty: bool = False) -> None:
        super().__init__()
        self.kind = kind
        self._start, self._may_be_empty = start, may_be_empty
        self._role = ""
        self.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.setAcceptDrops(False)
        self.textEdited.connect(self._on_edit)

    @property
    def number(self) -> float | None:
        """What stands in the field; None where it cannot be used, or is empty."""
        return self.kind.read(self.text())

    @property
    def is_wrong(self) -> bool:
        is_empty = not self.text().strip()
        return self.number is None and not (is_empty and self._may_be_empty)

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

    def keyPressEvent(self, event: QKeyEvent) -> None:
        steps = _STEPS.get(Qt.Key(event.key()), 0)
        if not steps or event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier or self.isReadOnly():
            super().keyPressEvent(event)
            return
        event.accept()
        number = self.number
        if number is None and self.text().strip():
            return  # what is wrong is corrected by whoever typed it
        self.setText(self.kind.shown(self.kind.stepped(self._start if number is None else number, steps)))
        self._on_edit()

    def _on_edit(self) -> None:
        self._role = ""
        self._mark()
        self.edited.emit()

    def _mark(self) -> None:
        set_role(self, "wrong" if self.is_wrong else self._role)
