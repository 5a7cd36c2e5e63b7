"""Inspects a window as a screen reader does: roles, names, values, and changes of names."""

from collections.abc import Iterator
from typing import Any

import pytest
from PySide6.QtGui import QAccessible, QAccessibleAnnouncementEvent, QAccessibleInterface
from PySide6.QtWidgets import QAbstractButton, QLabel, QWidget

from tests.support.window.controls import visible_in

_SKIPPED = frozenset({QAccessible.Role.Client, QAccessible.Role.Border, QAccessible.Role.NoRole})
"""Roles that screen readers ignore."""


def interfaces(root: QWidget) -> Iterator[QAccessibleInterface]:
    """Yield all visible interfaces below `root`, outermost first."""
    yield from _below(QAccessible.queryAccessibleInterface(root))


def _below(one: QAccessibleInterface) -> Iterator[QAccessibleInterface]:
    for index in range(one.childCount()):
        child: Any = one.child(index)  # None where Qt has none
        if child is not None and child.isValid() and not child.state().invisible:
            yield child
            yield from _below(child)


def name_of(widget: QWidget) -> str:
    """Return the name of a widget."""
    return _name(QAccessible.queryAccessibleInterface(widget))


def _name(one: QAccessibleInterface) -> str:
    return one.text(QAccessible.Text.Name)


def unheard(root: QWidget) -> list[str]:
    """Return a line for every widget that a screen reader ignores, or that has no name or range."""
    found = []
    for interface in interfaces(root):
        widget: Any = interface.object()  # None for an item of a list
        what = (
            f"{widget.objectName() or type(widget).__name__} ({interface.role().name})" if widget else _name(interface)
        )
        if interface.role() in _SKIPPED and widget is not None:
            if _name(interface):
                found.append(f"{what} has a name that nobody hears: {_name(interface)!r}")
            if interface.state().focusable:
                found.append(f"{what} takes the focus and has no role")
        if interface.state().focusable and not _name(interface) and widget is not None:
            found.append(f"{what} takes the focus and has no name")
        if interface.role() in (QAccessible.Role.SpinBox, QAccessible.Role.Slider):
            value: Any = interface.valueInterface()  # None where Qt has none
            if value is None or not value.minimumValue() < value.maximumValue():
                found.append(f"{what} has no range")
    return found


def misnamed(root: QWidget) -> list[str]:
    """Return a line for every button whose name lacks its text, which users of voice control say."""
    found = []
    for button in root.findChildren(QAbstractButton):
        words, name = button.text().replace("&", "").strip(" …"), button.accessibleName()
        if button.isVisible() and name and len(words) > 1 and words.lower() not in name.lower():
            found.append(f"{button.objectName()} is called {name!r} and says {words!r}")
    return found


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
