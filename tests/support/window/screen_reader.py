"""A window as a screen reader meets it: roles, names and values, and the changes that it is told of."""

from collections.abc import Iterator
from typing import Any

from PySide6.QtGui import QAccessible, QAccessibleInterface
from PySide6.QtWidgets import QAbstractButton, QLabel, QWidget

_SKIPPED = frozenset({QAccessible.Role.Client, QAccessible.Role.Border, QAccessible.Role.NoRole})
"""Roles that screen readers pass over, name and all."""


def interfaces(root: QWidget) -> Iterator[QAccessibleInterface]:
    """All in sight below `root`, outermost first."""
    yield from _below(QAccessible.queryAccessibleInterface(root))


def _below(one: QAccessibleInterface) -> Iterator[QAccessibleInterface]:
    for index in range(one.childCount()):
        child: Any = one.child(index)  # None where Qt has none
        if child is not None and child.isValid() and not child.state().invisible:
            yield child
            yield from _below(child)


def name_of(widget: QWidget) -> str:
    """What it says when it is asked."""
    return _name(QAccessible.queryAccessibleInterface(widget))


def _name(one: QAccessibleInterface) -> str:
    return one.text(QAccessible.Text.Name)


def unheard(root: QWidget) -> list[str]:
    """What a screen reader passes over, or tells no value of."""
    found = []
    for one in interfaces(root):
        widget: Any = one.object()  # None for an item of a list
        what = f"{widget.objectName() or type(widget).__name__} ({one.role().name})" if widget else _name(one)
        if one.role() in _SKIPPED and widget is not None:
            if _name(one):
                found.append(f"{what} has a name that nobody hears: {_name(one)!r}")
            if one.state().focusable:
                found.append(f"{what} takes the focus and has no role")
        if one.state().focusable and not _name(one) and widget is not None:
            found.append(f"{what} takes the focus and has no name")
        if one.role() in (QAccessible.Role.SpinBox, QAccessible.Role.Slider):
            value: Any = one.valueInterface()  # None where Qt has none
            if value is None or not value.minimumValue() < value.maximumValue():
                found.append(f"{what} has no range")
    return found


def misnamed(root: QWidget) -> list[str]:
    """Whose name lacks the words that stand on it: who speaks to the computer says these."""
    found = []
    for button in root.findChildren(QAbstractButton):
        words, name = button.text().replace("&", "").strip(" …"), button.accessibleName()
        if button.isVisible() and name and len(words) > 1 and words.lower() not in name.lower():
            found.append(f"{button.objectName()} is called {name!r} and says {words!r}")
    return found


class NameChanges:
    """Counts what screen readers are told of: Qt's own names and descriptions, and texts that stand for a name."""

    def __init__(self, root: QWidget) -> None:
        self._root = root
        self._seen: dict[QWidget, tuple[str, str]] = {}
        self.found: list[str] = []

    def look(self, *, counts: bool = True) -> None:
        for widget in self._root.findChildren(QWidget):
            if not widget.isVisible():
                self._seen.pop(widget, None)
                continue
            # Not what a widget of ours answers when it is asked.
            name = QWidget.accessibleName(widget) or (widget.text() if isinstance(widget, QLabel) else "")
            told = name, QWidget.accessibleDescription(widget)
            before = self._seen.setdefault(widget, told)
            if told != before:
                self._seen[widget] = told
                if counts:
                    self.found.append(f"{widget.objectName()}: {before} -> {told}")
