"""What a screen reader hears: names, changes of them, and what is announced."""

import pytest
from PySide6.QtGui import QAccessible, QAccessibleAnnouncementEvent
from PySide6.QtWidgets import QWidget


def name_of(widget: QWidget) -> str:
    return QAccessible.queryAccessibleInterface(widget).text(QAccessible.Text.Name)


def announced(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return what is announced from now on; what is urgent ends with "!"."""
    said: list[str] = []

    class Heard(QAccessible):
        @staticmethod
        def updateAccessibility(event: QAccessibleAnnouncementEvent) -> None:  # type: ignore[override]
            is_urgent = event.politeness() is QAccessible.AnnouncementPoliteness.Assertive
            said.append(event.message() + "!" * is_urgent)

    monkeypatch.setattr("ui.style.appearance.QAccessible", Heard)
    return said
