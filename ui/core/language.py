"""The language of the window, which is chosen before the first widget is made."""

import logging

from PySide6.QtCore import QLibraryInfo, QLocale, QTranslator
from PySide6.QtGui import QFontDatabase
from PySide6.QtWidgets import QApplication

from app.text.i18n import CHINESE, set_language, tr

_log = logging.getLogger(__name__)


def has_font_for(language: str) -> bool:
    return language != CHINESE or bool(QFontDatabase.families(QFontDatabase.WritingSystem.SimplifiedChinese))


def use_language(app: QApplication, name: str) -> None:
    """Every text that is made from now on is in this language; see `app.text.i18n.set_language` for the names."""
    set_language(name)
    QLocale.setDefault(QLocale(name if name == CHINESE else "en"))
    app.setApplicationDisplayName(tr("DPS-S Configurator"))  # some systems add it to each window's title
    # Qt's own texts (OK, Cancel, the menus of text fields) come with its wheel.
    qt_texts = app.findChild(QTranslator) or QTranslator(app)
    app.removeTranslator(qt_texts)
    if name == CHINESE:
        folder = QLibraryInfo.path(QLibraryInfo.LibraryPath.TranslationsPath)
        if qt_texts.load(f"qtbase_{name}", folder):
            app.installTranslator(qt_texts)
        else:
            _log.warning("Qt's own texts for %s are not in %s", name, folder)
