"""Tells screen readers what happened, wherever the focus is."""

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAccessible, QAccessibleAnnouncementEvent
from PySide6.QtWidgets import QApplication, QWidget

_POLITENESS = QAccessible.AnnouncementPoliteness


class Announcer(QObject):
    """One per application: `announcer()`. For events only, not for values that change all the time."""

    announced = Signal(str, bool)
    """The text, and whether it was urgent."""

    def announce(self, text: str, *, is_urgent: bool = False) -> None:
        """`text` in the language in use. `is_urgent`: it interrupts what is being read."""
        speaker = _speaker()
        if not text or speaker is None:
            return
        event = QAccessibleAnnouncementEvent(speaker, text)
        event.setPoliteness(_POLITENESS.Assertive if is_urgent else _POLITENESS.Polite)
        QAccessible.updateAccessibility(event)
        self.announced.emit(text, is_urgent)


def _speaker() -> QWidget | None:
    """The active window, else the first visible one."""
    front = QApplication.activeWindow()
    return front or next((window for window in QApplication.topLevelWidgets() if window.isVisible()), None)


_announcer: Announcer | None = None


def announcer() -> Announcer:
    """The application's only `Announcer`."""
    global _announcer  # noqa: PLW0603  as Qt has one application
    if _announcer is None:
        _announcer = Announcer()
    return _announcer
