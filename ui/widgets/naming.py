"""Sets object and accessible names of widgets and actions."""

from typing import TypeVar

from PySide6.QtCore import QObject

Named = TypeVar("Named", bound=QObject)


def named(one: Named, name: str) -> Named:
    """`one` with its object name set."""
    one.setObjectName(name)
    return one
