"""Switches the language of the window and of Qt's own texts while it is open."""

import logging

from PySide6.QtCore import QEvent, QLibraryInfo, QLocale, QTranslator
from PySide6.QtGui import QFontDatabase
from PySide6.QtWidgets import QApplication

from app.text.i18n import CHINESE, language, set_language, tr
from ui.core.texts import Texts

_log = logging.getLogger(__name__)


def has_font_for(name: str) -> bool:
    """Whether some font of the system has this language's characters."""
    return name != CHINESE or bool(QFontDatabase.families(QFontDatabase.WritingSystem.SimplifiedChinese))


class LanguageSwitch:
    """Bound texts are applied again; what a widget words itself, it words again at `QEvent.LanguageChange`."""

    def __init__(self, app: QApplication, texts: Texts) -> None:
        self._app = app
        self._texts = texts
        self._qt_texts = QTranslator()

    @property
    def language(self) -> str:
        return language()

    def use(self, name: str) -> None:
        """Speak this language from now on; see `app.text.i18n.set_language` for the names."""
        set_language(name)
        self._app.removeTranslator(self._qt_texts)
        if name == CHINESE and self._has_qt_texts(name):
            self._app.installTranslator(self._qt_texts)
        QLocale.setDefault(QLocale(name if name == CHINESE else "en"))
        self._app.setApplicationDisplayName(tr("DPS-S Configurator"))  # some systems add it to each window's title
        self._texts.retranslate()
        for window in self._app.topLevelWidgets():
            self._app.sendEvent(window, QEvent(QEvent.Type.LanguageChange))

    def _has_qt_texts(self, name: str) -> bool:
        """Qt's own texts (OK, Cancel, the menus of text fields), loaded once; they come with its wheel."""
        folder = QLibraryInfo.path(QLibraryInfo.LibraryPath.TranslationsPath)
        if self._qt_texts.isEmpty() and not self._qt_texts.load(f"qtbase_{name}", folder):
            _log.warning("Qt's own texts for %s are not in %s", name, folder)
            return False
        return True
