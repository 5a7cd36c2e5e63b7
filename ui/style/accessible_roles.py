"""Roles and names for screen readers, of widgets that Qt knows nothing about.

Qt gives a widget of our own the role of a container, which screen readers skip. Here it has the role that its class
names in `accessible_role`; a container with a name is a group.

The name is asked for when somebody wants to know it, so it may hold a measured value or an age. A change of it is told
only where Qt's own property changes: see `PaintedWidget.announce` and `TickingLabel`.
"""

from typing import Final

from PySide6.QtCore import QObject
from PySide6.QtGui import QAccessible, QAccessibleInterface
from PySide6.QtWidgets import QAccessibleWidget, QFrame, QWidget

_CONTAINERS: Final = (QWidget, QFrame)
"""What Qt's own role says nothing of."""


class _Accessible(QAccessibleWidget):
    def text(self, kind: QAccessible.Text) -> str:
        widget: QWidget | None = self.widget()
        told = widget.accessibleName() if kind is QAccessible.Text.Name and widget is not None else ""
        return told or super().text(kind)


def _make(class_name: str, one: QObject) -> QAccessibleInterface | None:
    """Called by Qt for the class of `one` and all those above it, until it gets an answer."""
    if not isinstance(one, QWidget) or type(one).__name__ != class_name:
        return None
    role = getattr(one, "accessible_role", None)
    if role is None and one.accessibleName() and _qt_class(one) in _CONTAINERS:
        role = QAccessible.Role.Grouping
    return None if role is None else _Accessible(one, role)


def _qt_class(one: QWidget) -> type:
    return next(kind for kind in type(one).__mro__ if kind.__module__.startswith("PySide6."))


_is_installed = False


def install_accessible_roles() -> None:
    """Once for the application; before anybody asks."""
    global _is_installed  # noqa: PLW0603  as Qt has one list of them
    if not _is_installed:
        _is_installed = True
        QAccessible.installFactory(_make)
