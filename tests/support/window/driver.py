"""Finds, clicks and awaits widgets as a person at the window does."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TypeVar

from PySide6.QtWidgets import QAbstractButton, QWidget
from pytestqt.qtbot import QtBot

from tests.support.window.fakes_ui import WAIT_MS
from tests.support.window.steps import press

Found = TypeVar("Found", bound=QWidget)


class Driver(ABC):
    """Base of what drives a window or a page in tests."""

    qtbot: QtBot

    @property
    @abstractmethod
    def root(self) -> QWidget:
        """The widget in whose children is searched."""

    def find(self, kind: type[Found], name: str = "") -> Found:
        found = self.root.findChild(kind, name) if name else self.root.findChild(kind)
        assert found is not None, name or kind
        return found

    def click(self, widget: QWidget | str | None) -> None:
        """Click a widget, or a button given by its name, once it is visible and enabled."""
        button: QWidget | None = self.find(QAbstractButton, widget) if isinstance(widget, str) else widget
        assert button is not None
        self.until(lambda: button.isVisible() and button.isEnabled())
        press(self.qtbot, button)

    def until(self, is_so: Callable[[], object], timeout_ms: int = WAIT_MS) -> None:
        self.qtbot.waitUntil(lambda: bool(is_so()), timeout=timeout_ms)
