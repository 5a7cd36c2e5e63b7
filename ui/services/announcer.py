"""Tells screen readers what happened, wherever the focus is."""

from PySide6.QtGui import QAccessible, QAccessibleAnnouncementEvent
from PySide6.QtWidgets import QApplication

_POLITENESS = QAccessible.AnnouncementPoliteness


def announce(text: str, *, is_urgent: bool = False) -> None:
    """For events only, not for values that change all the time. `text` is in the language in use. `is_urgent`: it
    interrupts what is being read."""
    visible = (window for window in QApplication.topLevelWidgets() if window.isVisible())
    speaker = QApplication.activeWindow() or next(visible, None)
    if text and speaker is not None:
        event = QAccessibleAnnouncementEvent(speaker, text)
        event.setPoliteness(_POLITENESS.Assertive if is_urgent else _POLITENESS.Polite)
        QAccessible.updateAccessibility(event)
