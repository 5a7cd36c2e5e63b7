"""Cancels pending operations when the computer resumes from sleep."""

from typing import Final

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QWidget

from app.procedures.act import Armed
from app.text.durations import duration
from app.text.i18n import tr
from ui.acts.confirm import Confirm
from ui.core.connector import Connector
from ui.shell.status_bar import StatusBar

SHOWN_FOR_S: Final = 60.0
"""Long, since whoever opens the lid may not look at once."""


class ResumeWatcher(QObject):
    """Withdraws confirmations and disarms. The session itself marks values as stale and reads them again
    (`app.engine.session`)."""

    def __init__(self, connector: Connector, window: QWidget, armed: Armed, said: StatusBar) -> None:
        super().__init__(window)
        self._window, self._armed, self._said = window, armed, said
        connector.slept.connect(self._wake)

    def _wake(self, slept_s: float) -> None:
        self._armed.act = None
        for question in self._window.findChildren(Confirm):
            question.withdraw()
        self._said.show_message(
            tr("The computer slept for {time}; everything is read again.", time=duration(slept_s)), SHOWN_FOR_S
        )
