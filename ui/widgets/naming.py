"""A name for each widget and action: tests find it by that, and so does whoever automates the window."""

from typing import TypeVar

from PySide6.QtCore import QObject

Named = TypeVar("Named", bound=QObject)


def named(one: Named, name: str) -> Named:
    """`one` with its object name set."""
    one.setObjectName(name)
    return one
