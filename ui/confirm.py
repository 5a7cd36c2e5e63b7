"""A second click for what changes the module: ask, then do it or cancel. Cancel is where the first button was."""

from typing import Final

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QHideEvent, QKeyEvent
from PySide6.QtWidgets import QHBoxLayout, QPushButton, QWidget

from ui.named import named
from ui.texts import Texts
from ui.theme import Space

ASKS_FOR_MS: Final = 10_000
"""A question that nobody answers is withdrawn."""


class Confirm(QWidget):
    """`confirmed` comes once for one question. The second press of a double click falls on Cancel."""

    asked = Signal()
    confirmed = Signal()
    withdrawn = Signal()

    def __init__(self, name: str, texts: Texts, *, ask: str, go: str) -> None:
        super().__init__()
        self.setObjectName(f"{name}_confirm")
        self.ask = named(QPushButton(), f"{name}_ask")
        self.go = named(QPushButton(), f"{name}_go")
        self.cancel = named(QPushButton(), f"{name}_cancel")
        for button, english in ((self.ask, ask), (self.go, go)):
            button.setProperty("role", "danger")
            texts.bind(button.setText, english)
            texts.bind(button.setAccessibleName, english)
            texts.bind(button.setToolTip, english)
        texts.bind(self.cancel.setText, "Cancel")
        texts.bind(self.cancel.setAccessibleName, "Cancel")
        texts.bind(self.cancel.setToolTip, "Send nothing (Esc)")
        self.ask.clicked.connect(self._ask)
        self.go.clicked.connect(self._go)
        self.cancel.clicked.connect(self.withdraw)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(Space.S)
        row.addStretch(1)
        for button in (self.go, self.ask, self.cancel):
            row.addWidget(button)
        self.setTabOrder(self.ask, self.cancel)
        self.setTabOrder(self.cancel, self.go)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(ASKS_FOR_MS)
        self._timer.timeout.connect(self.withdraw)
        self._show(is_asking=False)

    @property
    def is_asking(self) -> bool:
        return self._timer.isActive()

    def set_possible(self, is_possible: bool) -> None:
        """Whether there is any point in asking. A question that stands is withdrawn when there no longer is."""
        self.ask.setEnabled(is_possible)
        if not is_possible:
            self.withdraw()

    def withdraw(self) -> None:
        """Nothing is sent."""
        if self.is_asking:
            self._timer.stop()
            had_focus = self.go.hasFocus() or self.cancel.hasFocus()
            self._show(is_asking=False)
            if had_focus:
                self.ask.setFocus()
            self.withdrawn.emit()

    def _ask(self) -> None:
        self._timer.start()
        self._show(is_asking=True)
        self.cancel.setFocus()
        self.asked.emit()

    def _go(self) -> None:
        if self.is_asking:
            self._timer.stop()
            self._show(is_asking=False)
            self.confirmed.emit()

    def _show(self, *, is_asking: bool) -> None:
        # The new ones first: else the focus would wander off in between.
        self.go.setVisible(is_asking)
        self.cancel.setVisible(is_asking)
        self.ask.setVisible(not is_asking)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape and self.is_asking:
            self.withdraw()
        else:
            super().keyPressEvent(event)

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        if not self.isVisible():
            self.withdraw()
