"""Applies and saves preferences."""

from collections.abc import Callable

from PySide6.QtCore import QObject, Signal

from ui.core.language_switch import LanguageSwitch
from ui.core.preferences import Preferences
from ui.style.appearance import Appearance
from ui.style.theme import Choice


class Choices(QObject):
    """Each choice applies at once, and at the next start."""

    changed = Signal()

    def __init__(self, appearance: Appearance, language_switch: LanguageSwitch, preferences: Preferences) -> None:
        super().__init__()
        self._appearance, self._language_switch = appearance, language_switch
        self.remembered = preferences
        self.has_font_for: Callable[[str], bool] = lambda _name: True
        self.report_no_font: Callable[[], object] = lambda: None

    def use_language(self, name: str) -> None:
        """Keeps the language, and reports it, if no font has the characters of the new one."""
        if not self.has_font_for(name):
            self.report_no_font()
            return
        self._language_switch.use(name)
        self.remembered.language = name
        self.changed.emit()

    def use_theme(self, key: str) -> None:
        self._appearance.choose(Choice(key))
        self.remembered.theme = key
        self.changed.emit()

    def use_zoom(self, percent: int) -> None:
        self._appearance.zoom(percent)
        self.remembered.zoom_percent = percent
        self.changed.emit()

        self.changed.emit()
