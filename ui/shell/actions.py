"""Menu bar: all actions of the window with their shortcuts."""

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QMainWindow, QMenu

from app.text.i18n import CHINESE, ENGLISH
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.services.context import PageEntry
from ui.style.icons import Icon, icon
from ui.style.theme import Choice
from ui.widgets.naming import named

_THEMES = (
    (Choice.AUTO, marked("System")),
    (Choice.LIGHT, marked("Bright")),
    (Choice.DARK, marked("Dark")),
    (Choice.SUNLIGHT, marked("Sunlight")),
)
# Each language in its own words, so that whoever is lost in the other one finds it.
_LANGUAGES = ((ENGLISH, "English"), (CHINESE, "简体中文"))


class Actions:
    """Makes menus and actions; what they do is connected by the window."""

    def __init__(self, window: QMainWindow, texts: Texts, entries: tuple[PageEntry, ...]) -> None:
        self._window = window
        self._texts = texts
        file, module = self._menu("menu_file", marked("&File")), self._menu("menu_module", marked("&Module"))
        view, help_menu = self._menu("menu_view", marked("&View")), self._menu("menu_help", marked("&Help"))
        self.open = self._action(file, "act_open", marked("Open…"), "Ctrl+Alt+O")
        self.recent = QMenu(window)
        self._add_menu(file, self.recent, "menu_recent", marked("Recent files"))
        file.addSeparator()
        self.connect = self._action(file, "act_connect", marked("Connect…"), "Ctrl+K")
        self.disconnect = self._action(file, "act_disconnect", marked("Disconnect"), "Ctrl+D")
        file.addSeparator()
        self.quit = self._action(file, "act_quit", marked("Quit"), "Ctrl+Q")
        self.lock = self._action(module, "act_lock", marked("LOCK"), "Ctrl+L")
        self.lock.setShortcutContext(Qt.ShortcutContext.ApplicationShortcut)
        self.lock.setIcon(icon(Icon.LOCK))
        self.find_rate = self._action(module, "act_find_rate", marked("Find the rate"), None)
        self.pages = {
            entry.key: self._action(view, f"act_page_{entry.key}", entry.title, f"Ctrl+{number}")
            for number, entry in enumerate(entries, start=1)
        }
        view.addSeparator()
        themes, languages = QMenu(window), QMenu(window)
        self._add_menu(view, themes, "menu_theme", marked("Theme"))
        self.themes = self._choices(themes, "theme", [(choice.value, title) for choice, title in _THEMES])
        self._add_menu(view, languages, "menu_language", marked("Language"))
        self.languages = self._choices(languages, "language", list(_LANGUAGES))
        self.simulator = self._action(view, "act_simulator", marked("Simulated module panel"), "F4")
        self.simulator.setCheckable(True)
        self.full_screen = self._action(view, "act_full_screen", marked("Full screen"), "F11")
        self.full_screen.setCheckable(True)
        self.tour = self._action(help_menu, "act_tour", marked("Tour on a simulated module"), None)
        self.guide = self._action(help_menu, "act_guide", marked("User guide"), "F1")
        self.keys = self._action(help_menu, "act_keys", marked("Keyboard shortcuts"), "Ctrl+F1")
        help_menu.addSeparator()
        self.what = self._action(help_menu, "act_what", marked("What is this? Point at it"), "Shift+F1")
        self.what_focused = self._action(
            help_menu, "act_what_focused", marked("What has the keyboard?"), "Ctrl+Shift+F1"
        )
        help_menu.addSeparator()
        self.about = self._action(help_menu, "act_about", marked("About"), None)

    def choose(self, group: dict[str, QAction], key: str) -> None:
        """Tick the entry of this key, where there is one."""
        if key in group:
            group[key].setChecked(True)

    def when_chosen(self, group: dict[str, QAction], act: Callable[[str], None]) -> None:
        for key, action in group.items():
            action.triggered.connect(partial(_call, act, key))

    def _menu(self, name: str, english: str) -> QMenu:
        menu = named(self._window.menuBar().addMenu(""), name)
        self._texts.bind(menu.setTitle, english)
        return menu

    def _add_menu(self, parent: QMenu, menu: QMenu, name: str, english: str) -> None:
        menu.setObjectName(name)
        parent.addMenu(menu)
        self._texts.bind(menu.setTitle, english)

    def _action(self, menu: QMenu, name: str, english: str, key: str | None) -> QAction:
        action = named(QAction(self._window), name)
        if key is not None:
            action.setShortcut(QKeySequence(key))
        self._texts.bind(action.setText, english)
        menu.addAction(action)
        # Also on the window: a shortcut of a menu that is hidden would be dead.
        self._window.addAction(action)
        return action

    def _choices(self, menu: QMenu, kind: str, entries: list[tuple[str, str]]) -> dict[str, QAction]:
        group = QActionGroup(menu)
        actions = {}
        for key, title in entries:
            action = named(QAction(menu), f"act_{kind}_{key}")
            action.setCheckable(True)
            self._texts.bind(action.setText, title)
            group.addAction(action)
            menu.addAction(action)
            actions[key] = action
        return actions


def _call(act: Callable[[str], None], key: str, _is_checked: bool = False) -> None:
    act(key)
