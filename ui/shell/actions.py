"""The menu: all actions of the window with their shortcuts."""

from collections.abc import Callable

from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMainWindow, QMenu, QWidget

from app.text.i18n import tr
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.services.context import PageEntry
from ui.shell.lock_above import LOCK_KEYS
from ui.style.icons import Icon, icon
from ui.widgets.controls import Shortcut, name_of
from ui.widgets.naming import named


class Actions:
    """Creates menus and actions, which the window connects."""

    def __init__(self, window: QMainWindow, texts: Texts, entries: tuple[PageEntry, ...]) -> None:
        self._window = window
        self._texts = texts
        self.main = named(QMenu(window), "main_menu")
        file, module = self._menu("menu_file", marked("&File")), self._menu("menu_module", marked("&Module"))
        self.page = self._menu("menu_page", marked("&Page"))
        view, help_menu = self._menu("menu_view", marked("&View")), self._menu("menu_help", marked("&Help"))
        self.open = self._action(file, "act_open", marked("Open…"), "Ctrl+Alt+O")
        self.recent = self._menu("menu_recent", marked("Recent files"), file)
        self.save = self._action(file, "act_save", marked("Save…"), None)
        self.export = self._action(file, "act_export", marked("Export…"), None)
        file.aboutToShow.connect(self._offer_saving)
        file.addSeparator()
        self.connect = self._action(file, "act_connect", marked("Connect…"), "Ctrl+K")
        self.disconnect = self._action(file, "act_disconnect", marked("Disconnect"), "Ctrl+D")
        file.addSeparator()
        self.archive = self._action(file, "act_archive", marked("Archive of all stations…"), None)
        self.preferences = self._action(file, "act_preferences", marked("Preferences…"), "Ctrl+,")
        self.quit = self._action(file, "act_quit", marked("Quit"), "Ctrl+Q")
        self.lock = self._action(module, "act_lock", marked("LOCK"), "Ctrl+L")
        self.lock.setShortcuts([QKeySequence(key) for key in LOCK_KEYS])  # which `LockAbove` handles in every window
        self.lock.setIcon(icon(Icon.LOCK))
        self.find_rate = self._action(module, "act_find_rate", marked("Find the rate"), None)
        self.simulator = self._action(module, "act_simulator", marked("Simulated module panel"), "F4")
        self.simulator.setCheckable(True)
        self.page.aboutToShow.connect(self._fill_page)
        self.pages = {
            entry.key: self._action(view, f"act_page_{entry.key}", entry.title, f"Ctrl+{number % 10}")
            for number, entry in enumerate(entries, start=1)
        }
        view.addSeparator()
        self.names = self._action(view, "act_names", marked("Wide sidebar"), "Ctrl+B")
        self.names.setCheckable(True)
        self.full_screen = self._action(view, "act_full_screen", marked("Full screen"), "F11")
        self.full_screen.setCheckable(True)
        self.guide = self._action(help_menu, "act_guide", marked("User guide"), "F1")
        self.keys = self._action(help_menu, "act_keys", marked("Keyboard shortcuts"), "Ctrl+F1")
        help_menu.addSeparator()
        self.what = self._action(help_menu, "act_what", marked("What is this? Point at it"), "Shift+F1")
        self.what_focused = self._action(
            help_menu, "act_what_focused", marked("What has the keyboard?"), "Ctrl+Shift+F1"
        )
        help_menu.addSeparator()
        self.about = self._action(help_menu, "act_about", marked("About"), None)
        self.find_page: Callable[[], QWidget | None] = lambda: None
        """Returns the current page."""

    def page_shortcuts(self) -> list[Shortcut]:
        """The shortcuts of the visible controls of the current page."""
        page = self.find_page()
        found = [] if page is None else page.findChildren(Shortcut)
        return [one for one in found if one.control.isVisible()]

    def _saving(self, key: str) -> Shortcut | None:
        """The shortcut of the current page with this key."""
        keys = QKeySequence(key)
        return next((one for one in self.page_shortcuts() if keys in one.shortcuts()), None)

    def _offer_saving(self) -> None:
        """Save and Export are the current page's Ctrl+S and Ctrl+Shift+S."""
        for action, key in ((self.save, "Ctrl+S"), (self.export, "Ctrl+Shift+S")):
            offered = self._saving(key)
            action.setEnabled(offered is not None and offered.control.isEnabled())
            action.setToolTip("" if offered is None else offered.control.accessibleName())

    def save_page(self) -> None:
        self._press("Ctrl+S")

    def export_page(self) -> None:
        self._press("Ctrl+Shift+S")

    def _press(self, key: str) -> None:
        offered = self._saving(key)
        if offered is not None and offered.control.isEnabled():
            offered.trigger()

    def _fill_page(self) -> None:
        self.page.clear()
        for one in self.page_shortcuts():
            keys = one.shortcut().toString(QKeySequence.SequenceFormat.NativeText)
            action = self.page.addAction(f"{name_of(one.control).replace('&', '&&')}\t{keys}")
            action.setObjectName(f"{one.objectName()}_entry")
            action.setEnabled(one.control.isEnabled())
            action.triggered.connect(one.trigger)
        if self.page.isEmpty():
            self.page.addAction(tr("No shortcuts on this page")).setEnabled(False)

    def when_chosen(self, group: dict[str, QAction], act: Callable[[str], None]) -> None:
        for key, action in group.items():
            action.triggered.connect(lambda _checked, key=key: act(key))

    def _menu(self, name: str, english: str, parent: QMenu | None = None) -> QMenu:
        menu = named(QMenu(parent or self.main), name)
        (parent or self.main).addMenu(menu)
        self._texts.bind(menu.setTitle, english)
        return menu

    def _action(self, menu: QMenu, name: str, english: str, key: str | None) -> QAction:
        action = named(QAction(self._window), name)
        if key is not None:
            action.setShortcut(QKeySequence(key))
        self._texts.bind(action.setText, english)
        menu.addAction(action)
        # Also on the window: shortcuts of a hidden menu do not work.
        self._window.addAction(action)
        return action
