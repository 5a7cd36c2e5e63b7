"""Actions of the Help menu, and "What's this?" of every control. All help windows are modeless: LOCK stays within
reach."""

from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QEvent, QObject
from PySide6.QtWidgets import QWhatsThis, QWidget

from app.text.i18n import tr
from protocol.translatable import marked
from ui.services.context import PageEntry, Services
from ui.shell.actions import MenuEntry
from ui.shell.main_window import MainWindow
from ui.widgets.controls import name_of
from ui.widgets.gestures import application

if TYPE_CHECKING:
    from ui.help.windows import GuideViewer, ShortcutsView

_QUESTIONS: Final = (QEvent.Type.QueryWhatsThis, QEvent.Type.WhatsThis)
_SAYS_TOOLTIP: Final = "says_tooltip"


def explain(widget: QWidget) -> None:
    """Where neither a widget nor what it is part of was made with a text, the nearest with a tooltip or an accessible
    name gets that."""
    around = [widget]
    while (parent := around[-1].parentWidget()) is not None:
        around.append(parent)
    if any(candidate.whatsThis() and not candidate.property(_SAYS_TOOLTIP) for candidate in around):
        return
    for candidate in around:
        candidate.setWhatsThis(candidate.toolTip() or name_of(candidate))
        candidate.setProperty(_SAYS_TOOLTIP, True)
        if candidate.whatsThis():
            return


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
            MenuEntry("what", marked("What is this? Point at it"), self._ask, "Shift+F1"),
            None,
            MenuEntry("about", marked("About"), self.show_about),
        )

    # "What's this?"

    def _ask(self) -> None:
        """The next click explains a control."""
        if not QWhatsThis.inWhatsThisMode():
            application().installEventFilter(self)
            QWhatsThis.enterWhatsThisMode()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Of the application, until the click."""
        if event.type() == QEvent.Type.LeaveWhatsThisMode:
            application().removeEventFilter(self)
        elif event.type() in _QUESTIONS and isinstance(watched, QWidget):
            explain(watched)
        return False

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
