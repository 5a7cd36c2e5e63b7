"""A window as a screen reader meets it: names, and the changes that it is told of."""

from PySide6.QtGui import QAccessible
from PySide6.QtWidgets import QLabel, QWidget


def name_of(widget: QWidget) -> str:
    """What it says when it is asked."""
    return QAccessible.queryAccessibleInterface(widget).text(QAccessible.Text.Name)


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
