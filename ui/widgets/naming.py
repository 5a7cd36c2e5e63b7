"""Sets object and accessible names of widgets and actions."""

from typing import TypeVar

from PySide6.QtCore import QObject

Named = TypeVar("Named", bound=QObject)


def named(one: Named, name: str, role: str = "") -> Named:
    """`one` with its object name set, and its role in the style sheet."""
    one.setObjectName(name)
    if role:
        one.setProperty("role", role)
    return one
