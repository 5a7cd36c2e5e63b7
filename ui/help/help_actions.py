"""Actions of the Help menu. All help windows are modeless, so that LOCK stays within reach."""

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from app.text.i18n import tr
from protocol.translatable import marked
from ui.services.context import PageEntry, Services
from ui.shell.actions import MenuEntry
from ui.shell.main_window import MainWindow

if TYPE_CHECKING:
    from ui.help.guide_viewer import GuideViewer
    from ui.help.small_windows import ShortcutsView
    from ui.help.whats_this import WhatsThis


class HelpActions(QObject):
    """Imports each part of the help when it is first used."""

    def __init__(self, window: MainWindow, services: Services, entries: tuple[PageEntry, ...]) -> None:
        super().__init__(window)
        self._window, self._services, self._entries = window, services, entries
        self._explaining: WhatsThis | None = None
        self._guide: GuideViewer | None = None
        self._keys: ShortcutsView | None = None
        window.menus.add(
            "help",
            MenuEntry("guide", marked("User guide"), self.show_guide, "F1"),
            MenuEntry("keys", marked("Keyboard shortcuts"), self.show_keys, "Ctrl+F1"),
            None,
            MenuEntry("what", marked("What is this? Point at it"), self.ask_what, "Shift+F1"),
            MenuEntry("what_focused", marked("What has the keyboard?"), self.show_focus_help, "Ctrl+Shift+F1"),
            None,
            MenuEntry("about", marked("About"), self.show_about),
        )
        window.pages_made.connect(self.explain)
        window.retranslated.connect(self.explain)
        window.port_opened.connect(self.show_next_step)

    def show_next_step(self, is_first: bool) -> None:
        """Called when a module answers; `is_first`: for the first time on this computer."""
        if is_first:
            self._window.show_message(tr("Next: Settings, then Pre-flight."))

    # What's this

    @property
    def is_explaining(self) -> bool:
        return self._explaining is not None and self._explaining.is_under_way

    def explain(self) -> None:
        """Sets the "What's this?" texts of all controls, in the language in use, from the event loop."""
        self._explainer().begin()

    def ask_what(self) -> None:
        """Enters "What's this?" mode."""
        self._explainer().ask()

    def show_focus_help(self) -> None:
        if not self._explainer().show_focus_help():
            self._window.show_message(tr("Nothing has the focus: press Tab."))

    def _explainer(self) -> "WhatsThis":
        from ui.help.whats_this import WhatsThis

        if self._explaining is None:
            self._explaining = WhatsThis(self._window)
        return self._explaining

    # Documents

    def show_guide(self) -> None:
        from ui.help.guide_viewer import GuideViewer, guide_page

        if guide_page() is None:
            self._window.show_message(tr("The user guide is not installed."))
            return
        if self._guide is None:
            self._guide = GuideViewer(self._services.texts, self._window)
        self._guide.bring_up()
        chosen = "" if self._window.panel.isVisible() else self._window.navigation.chosen
        chapter = next((entry.chapter for entry in self._entries if entry.key == chosen), "Connect")
        self._guide.go_to_chapter(chapter)

    def show_keys(self) -> None:
        from ui.help.small_windows import ShortcutsView

        if self._keys is None:
            self._keys = ShortcutsView(self._window, self._services.texts, self._entries)
        self._keys.bring_up()

    def show_about(self) -> None:
        from ui.help.small_windows import show_about

        show_about(self._window)
