"""Two-step confirmation in the page: ask, then perform or cancel, each button in its own place."""

from math import ceil
from typing import Final

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QHideEvent, QKeyEvent
from PySide6.QtWidgets import QWidget

from app.text.i18n import tr
from ui.style.theme import Space, is_text_large
from ui.widgets.controls import TickingLabel, control, in_column, in_row, named, retain_size
from ui.widgets.step_button import StepButton, bring_into_sight, gestures, is_in_sight

# An unanswered question is withdrawn after this time.
ASKS_FOR_S: Final = 10.0
CHECK_EVERY_MS: Final = 100


class Confirm(QWidget):
    """`confirmed` is emitted once for a question."""

    asked = Signal()
    confirmed = Signal()

    def __init__(self, name: str, *, ask: str, go: str) -> None:
        super().__init__()
        self.setObjectName(f"{name}_confirm")
        self.is_asking = False
        self._asked_at = 0.0
        self.ask = control(StepButton(tr(ask)), f"{name}_ask", slot=self._ask)
        self.go = control(StepButton(tr(go)), f"{name}_go", role="danger", slot=self._go)
        cancel = StepButton(tr("Cancel"), is_safe=True)
        self.cancel = control(cancel, f"{name}_cancel", tip=tr("Nothing is sent."), key="Esc", slot=self.withdraw)
        self.left = named(TickingLabel(), f"{name}_left", "small", says=tr("Withdrawn in"))
        # Its room is that of the longest time: the buttons beside it never move.
        self.left.setText(tr("{value} s", value=ceil(ASKS_FOR_S)))
        self.left.setMinimumWidth(self.left.sizeHint().width())
        retain_size(self.left)
        for button in (self.ask, self.cancel, self.go):  # Tab leads from the answer that has the focus to the other one
            button.setParent(self)
        if is_text_large():  # there is no room for all in one row
            answers = in_row(1, self.go, self.cancel, spacing=Space.S)
            in_column(in_row(1, self.left, self.ask), answers, of=self, spacing=Space.S, margins=0)
        else:
            in_row(1, self.left, self.go, self.cancel, self.ask, of=self, spacing=Space.S, margins=0)
        self._timer = QTimer(self, interval=CHECK_EVERY_MS)
        self._timer.timeout.connect(self.check)
        self._show()

    def set_possible(self, is_possible: bool) -> None:
        """Enable or disable asking; disabling withdraws a question."""
        self.ask.setEnabled(is_possible)
        if not is_possible:
            self.withdraw()

    def withdraw(self) -> None:
        """Nothing is sent."""
        if self.is_asking:
            self.is_asking = False
            self._show()

    def check(self) -> None:
        """Withdraw a question that was not answered in time, or is no longer entirely visible."""
        if not self.is_asking:
            return
        left_s = self._asked_at + ASKS_FOR_S - gestures().clock()
        self.left.setText(tr("{value} s", value=ceil(left_s)))
        if left_s <= 0 or not is_in_sight(self):
            self.withdraw()

    def _ask(self) -> None:
        if not is_in_sight(self):
            bring_into_sight(self)
            return
        self.is_asking, self._asked_at = True, gestures().clock()
        self.check()
        self._show()
        self.cancel.setFocus()
        self.asked.emit()

    def _go(self) -> None:
        self.check()
        if self.is_asking:
            self.withdraw()
            self.confirmed.emit()

    def _show(self) -> None:
        for widget in (self.left, self.go, self.cancel):
            widget.setVisible(self.is_asking)
        self.ask.setVisible(not self.is_asking)
        if self.is_asking:
            self._timer.start()
        else:
            self._timer.stop()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape and self.is_asking:
            self.withdraw()
        else:
            super().keyPressEvent(event)

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        if not self.isVisible():
            self.withdraw()
