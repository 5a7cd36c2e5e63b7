"""Actions of the Help menu. All help windows are modeless: LOCK stays within reach."""

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from app.text.i18n import tr
from protocol.translatable import marked
from ui.services.context import PageEntry, Services
from ui.shell.actions import MenuEntry
from ui.shell.main_window import MainWindow

if TYPE_CHECKING:
    from ui.help.windows import GuideViewer, ShortcutsView


class HelpActions(QObject):
    """Imports the windows of the help when they are first used."""

    def __init__(self, window: MainWindow, services: Services, entries: tuple[PageEntry, ...]) -> None:
        super().__init__(window)
        self._window, self._services, self._entries = window, services, entries
        self._guide: GuideViewer | None = None
        self._keys: ShortcutsView | None = None
        window.menus.add(
            "help",
            MenuEntry("guide", marked("User guide"), self.show_guide, "F1"),
            MenuEntry("keys", marked("Keyboard shortcuts"), self.show_keys, "Ctrl+F1"),
            None,
            MenuEntry("about", marked("About"), self.show_about),
        )

    # Documents

    def show_guide(self) -> None:
        from ui.help.windows import GuideViewer, guide_page

        if guide_page() is None:
            self._window.show_message(tr("The user guide is not installed."))
            return
        if self._guide is None:
            self._guide = GuideViewer(self._window)
        self._guide.bring_up()
        chosen = "" if self._window.panel.isVisible() else self._window.navigation.chosen
        chapter = next((entry.chapter for entry in self._entries if entry.key == chosen), "Connect")
        self._guide.go_to_chapter(chapter)

    def show_keys(self) -> None:
        from ui.help.windows import ShortcutsView

        if self._keys is None:
            self._keys = ShortcutsView(self._window)
        self._keys.bring_up()

    def show_about(self) -> None:
        from ui.help.windows import show_about

        show_about(self._window)
