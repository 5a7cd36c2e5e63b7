"""Preferences, in one INI file in the platform's folder for settings; the language, chosen before the first widget."""

import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, Generic, NamedTuple, TypeVar

from platformdirs import user_config_path
from PySide6.QtCore import QByteArray, QLibraryInfo, QLocale, QSettings, QTranslator
from PySide6.QtGui import QFontDatabase
from PySide6.QtWidgets import QApplication

from app.text.i18n import CHINESE, set_language, tr
from protocol.catalogue import DEFAULT_BAUD_RATE

APPLICATION: Final = "dps-s-configurator"
MAX_ZOOM_PERCENT: Final = 200
_Value = TypeVar("_Value")
_log = logging.getLogger(__name__)


class LastPort(NamedTuple):
    """`identity` tells one adapter from another by its USB numbers; empty for what is no USB adapter."""

    device: str
    identity: str
    baud_rate: int


class _Entry(Generic[_Value]):
    """One entry of the file: `read` gets what is in it, None or spoilt where it was never set."""

    def __init__(self, key: str, read: Callable[[Any], _Value], write: Callable[[_Value], object] = str) -> None:
        self._key, self._read, self._write = key, read, write

    def __get__(self, preferences: "Preferences", _kind: type | None = None) -> _Value:
        return self._read(preferences.settings.value(self._key))

    def __set__(self, preferences: "Preferences", value: _Value) -> None:
        preferences.settings.setValue(self._key, self._write(value))


def _text(value: object) -> str:
    return value if isinstance(value, str) else ""


def _text_or_none(value: object) -> str | None:
    return _text(value) or None


def _lines(value: object) -> tuple[str, ...]:
    return tuple(filter(None, _text(value).split("\n")))


def _bytes(value: object) -> QByteArray | None:
    return value if isinstance(value, QByteArray) and not value.isEmpty() else None


def _number(value: object, usual: int, most: int) -> int:
    text = _text(value)
    return int(text) if text.isdecimal() and int(text) <= most else usual


class Preferences:
    """Typed access to the file. What is missing or spoilt in it reads as never set; a file that cannot be
    written is no reason to stop (a read-only home)."""

    language = _Entry("language", _text_or_none)
    theme = _Entry("theme", _text_or_none)
    # The size of text and controls.
    zoom_percent = _Entry("zoom_percent", lambda value: max(100, _number(value, 100, MAX_ZOOM_PERCENT)))
    # Paths, the last used first.
    recent_profiles = _Entry("profiles/recent", _lines, "\n".join)
    files_folder = _Entry("files/folder", _text)  # Where the dialog for files of any type begins
    # Who checked last.
    who = _Entry("preflight/who", _text)
    has_sounds = _Entry("sounds", lambda value: value == "on", lambda is_on: "on" if is_on else "off")
    geometry: _Entry[QByteArray | None] = _Entry("window/geometry", _bytes, lambda value: value)

    def __init__(self, path: Path | None = None) -> None:
        path = path or user_config_path(APPLICATION, appauthor=False) / "window.ini"
        self.settings = QSettings(str(path), QSettings.Format.IniFormat)

    def save(self) -> None:
        self.settings.sync()

    @property
    def last_port(self) -> LastPort | None:
        device, identity = (_text(self.settings.value(f"port/{key}")) for key in ("device", "identity"))
        rate = _number(self.settings.value("port/baud_rate"), DEFAULT_BAUD_RATE, 10_000_000)
        return LastPort(device, identity, rate) if device else None

    @last_port.setter
    def last_port(self, port: LastPort) -> None:
        for key, value in port._asdict().items():
            self.settings.setValue(f"port/{key}", str(value))

    @property
    def profile_folder(self) -> Path:
        """The folder in which a dialog for profiles begins."""
        return Path(self.recent_profiles[0]).parent if self.recent_profiles else Path.home()

    def add_profile(self, path: Path) -> None:
        name = str(path.absolute())
        others = (recent for recent in self.recent_profiles if recent != name)
        self.recent_profiles = (name, *others)[:8]


def has_font_for(language: str) -> bool:
    return language != CHINESE or bool(QFontDatabase.families(QFontDatabase.WritingSystem.SimplifiedChinese))


def use_language(app: QApplication, name: str) -> None:
    """Every text is in this language; see `app.text.i18n.set_language` for the names. Called once, at the start."""
    set_language(name)
    QLocale.setDefault(QLocale(name if name == CHINESE else "en"))
    app.setApplicationDisplayName(tr("DPS-S Configurator"))  # some systems add it to each window's title
    # Qt's own texts (OK, Cancel, the menus of text fields) come with its wheel.
    if name == CHINESE:
        qt_texts = QTranslator(app)
        folder = QLibraryInfo.path(QLibraryInfo.LibraryPath.TranslationsPath)
        if qt_texts.load(f"qtbase_{name}", folder):
            app.installTranslator(qt_texts)
        else:
            _log.warning("Qt's own texts for %s are not in %s", name, folder)
