"""Sets object names and roles in the style sheet."""

from typing import TypeVar

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QWidget

Named = TypeVar("Named", bound=QObject)


def named(one: Named, name: str, role: str = "") -> Named:
    """Sets the object name of `one`, and its role in the style sheet; returns it."""
    one.setObjectName(name)
    if role:
        one.setProperty("role", role)
    return one


def set_role(widget: QWidget, role: str) -> None:
    """Changes the role of `widget` in the style sheet."""
    if (widget.property("role") or "") != role:
        widget.setProperty("role", role)
        widget.style().unpolish(widget)
        widget.style().polish(widget)
