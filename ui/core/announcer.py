"""Speaks to whoever uses a screen reader: what has happened, once, whatever has the focus."""

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAccessible, QAccessibleAnnouncementEvent
from PySide6.QtWidgets import QApplication, QWidget

_POLITENESS = QAccessible.AnnouncementPoliteness


class Announcer(QObject):
    """One for the application: `announcer()`. Only for what happens once; nothing that is counted or measured."""

    announced = Signal(str, bool)
    """What was said, and whether it was urgent."""

    def say(self, text: str, *, is_urgent: bool = False) -> None:
        """`text` in the language in use. `is_urgent`: it interrupts what is being read."""
        speaker = _speaker()
        if not text or speaker is None:
            return
        event = QAccessibleAnnouncementEvent(speaker, text)
        event.setPoliteness(_POLITENESS.Assertive if is_urgent else _POLITENESS.Polite)
        QAccessible.updateAccessibility(event)
        self.announced.emit(text, is_urgent)


def _speaker() -> QWidget | None:
    """The window in front, else the first one in sight."""
    front = QApplication.activeWindow()
    return front or next((one for one in QApplication.topLevelWidgets() if one.isVisible()), None)


_one: Announcer | None = None


def announcer() -> Announcer:
    """The application's."""
    global _one  # noqa: PLW0603  as Qt has one application
    if _one is None:
        _one = Announcer()
    return _one
