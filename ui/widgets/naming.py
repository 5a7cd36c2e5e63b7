"""Sets object and accessible names of widgets and actions."""

from typing import TypeVar

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QWidget

Named = TypeVar("Named", bound=QObject)


def named(one: Named, name: str, role: str = "") -> Named:
    """`one` with its object name set, and its role in the style sheet."""
    one.setObjectName(name)
    if role:
        one.setProperty("role", role)
    return one


def set_role(widget: QWidget, role: str) -> None:
    """Give `widget` another role in the style sheet, and draw it so."""
    if (widget.property("role") or "") != role:
        widget.setProperty("role", role)
        widget.style().unpolish(widget)
        widget.style().polish(widget)
