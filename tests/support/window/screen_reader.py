"""What a screen reader hears: names, changes of them, and what is announced."""

import pytest
from PySide6.QtGui import QAccessible, QAccessibleAnnouncementEvent
from PySide6.QtWidgets import QLabel, QWidget

from tests.support.window.controls import visible_in


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


class NameChanges:
    """Records changes of names and descriptions, of which screen readers are notified."""

    def __init__(self, root: QWidget) -> None:
        self._root = root
        self._seen: dict[QWidget, tuple[str, str]] = {}
        self.found: list[str] = []

    def look(self, *, counts: bool = True) -> None:
        seen, self._seen = self._seen, {}
        for widget in visible_in(self._root):
            # Not what a widget of ours answers when it is asked.
            name = QWidget.accessibleName(widget) or (widget.text() if isinstance(widget, QLabel) else "")
            told = self._seen[widget] = name, QWidget.accessibleDescription(widget)
            before = seen.get(widget, told)
            if told != before and counts:
                self.found.append(f"{widget.objectName()}: {before} -> {told}")
