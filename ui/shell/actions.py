"""The menu: an action of the window is one record."""

from collections.abc import Callable
from typing import NamedTuple

from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMainWindow, QMenu

from app.text.i18n import tr
from protocol.translatable import marked
from ui.style.icons import Icon, icon
from ui.widgets.controls import named

_MENUS = {
    "file": marked("&File"),
    "module": marked("&Module"),
    "view": marked("&View"),
    "help": marked("&Help"),
}


class MenuEntry(NamedTuple):
    """An action. `text` is English, marked; `act` gets the state of one that `is_checkable`; `when` says whether it can
    be done now: see `Actions.refresh`."""

    name: str
    text: str
    act: Callable[..., object]
    key: str = ""
    when: Callable[[], bool] | None = None
    is_checkable: bool = False
    picture: Icon | None = None


class Actions:
    """The window's menus, and its actions by the name of their entries."""

    def __init__(self, window: QMainWindow) -> None:
        self._window = window
        self._actions: dict[str, QAction] = {}
        self._conditions: dict[QAction, Callable[[], bool]] = {}
        self.main = named(QMenu(window), "main_menu")
        self._menus: dict[str, QMenu] = {}
        for name, title in _MENUS.items():
            self.add_menu(name, title, self.main)
        self._menus["file"].aboutToShow.connect(self.refresh)

    def __getitem__(self, name: str) -> QAction:
        return self._actions[name]

    def add_menu(self, name: str, title: str, parent: QMenu | None = None) -> QMenu:
        """A menu in the file menu, or in its parent; `title` is English, marked."""
        around = parent or self._menus["file"]
        menu = self._menus[name] = named(QMenu(around), f"menu_{name}")
        around.addMenu(menu)
        menu.setTitle(tr(title))
        return menu

    def add(self, menu: str, *entries: MenuEntry | None) -> None:
        """At the end of a menu; None parts two groups."""
        for entry in entries:
            if entry is None:
                self._menus[menu].addSeparator()
                continue
            action = self._actions[entry.name] = named(QAction(self._window), f"act_{entry.name}")
            if entry.key:
                action.setShortcuts(QKeySequence.listFromString(entry.key))
            action.setAutoRepeat(False)  # a key that is held answers no question that it has raised
            action.setCheckable(entry.is_checkable)
            if entry.picture is not None:
                action.setIcon(icon(entry.picture))
            (action.toggled if entry.is_checkable else action.triggered).connect(entry.act)
            if entry.when is not None:
                self._conditions[action] = entry.when
            action.setText(tr(entry.text))
            self._menus[menu].addAction(action)
            self._window.addAction(action)  # shortcuts of a hidden menu do not work

    def refresh(self) -> None:
        """Enables what can be done now."""
        for action, when in self._conditions.items():
            action.setEnabled(when())
