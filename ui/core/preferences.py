"""Preferences in one INI file in the platform's folder for settings."""

from dataclasses import dataclass
from pathlib import Path

from platformdirs import user_config_path
from PySide6.QtCore import QByteArray, QSettings

from protocol.catalogue import DEFAULT_BAUD_RATE

APPLICATION = "dps-s-configurator"
MAX_ZOOM_PERCENT = 150
MAX_RECENT = 8
"""Profiles."""


@dataclass(frozen=True, slots=True)
class LastPort:
    """`identity` tells one adapter from another by its USB numbers; empty for what is no USB adapter."""

    device: str
    identity: str
    baud_rate: int


def settings_file() -> Path:
    return user_config_path(APPLICATION, appauthor=False) / "window.ini"


class Preferences:
    """Typed access to the file. What is missing or spoilt in it reads as never set; a file that cannot be
    written is no reason to stop (a read-only home)."""

    def __init__(self, path: Path | None = None) -> None:
        self._settings = QSettings(str(path or settings_file()), QSettings.Format.IniFormat)

    def save(self) -> None:
        self._settings.sync()

    @property
    def language(self) -> str | None:
        return self._text("language")

    @language.setter
    def language(self, name: str) -> None:
        self._settings.setValue("language", name)

    @property
    def theme(self) -> str | None:
        return self._text("theme")

    @theme.setter
    def theme(self, name: str) -> None:
        self._settings.setValue("theme", name)

    @property
    def zoom_percent(self) -> int:
        """The size of text and controls."""
        text = self._text("zoom_percent") or ""
        return int(text) if text.isdecimal() and 100 <= int(text) <= MAX_ZOOM_PERCENT else 100

    @zoom_percent.setter
    def zoom_percent(self, percent: int) -> None:
        self._settings.setValue("zoom_percent", str(percent))

    @property
    def has_sounds(self) -> bool:
        return self._text("sounds") == "yes"

    @has_sounds.setter
    def has_sounds(self, is_wanted: bool) -> None:
        self._settings.setValue("sounds", "yes" if is_wanted else "no")

    @property
    def is_sidebar_wide(self) -> bool:
        return self._text("window/sidebar") == "wide"

    @is_sidebar_wide.setter
    def is_sidebar_wide(self, is_wide: bool) -> None:
        self._settings.setValue("window/sidebar", "wide" if is_wide else "narrow")

    @property
    def last_port(self) -> LastPort | None:
        device = self._text("port/device")
        if device is None:
            return None
        rate = self._text("port/baud_rate") or ""
        return LastPort(device, self._text("port/identity") or "", int(rate) if rate.isdecimal() else DEFAULT_BAUD_RATE)

    @last_port.setter
    def last_port(self, port: LastPort) -> None:
        self._settings.setValue("port/device", port.device)
        self._settings.setValue("port/identity", port.identity)
        self._settings.setValue("port/baud_rate", str(port.baud_rate))

    @property
    def seen_ports(self) -> tuple[str, ...]:
        """Identities of the ports that were there at the last look."""
        return tuple(filter(None, (self._text("port/seen") or "").split("\n")))

    @seen_ports.setter
    def seen_ports(self, identities: tuple[str, ...]) -> None:
        self._settings.setValue("port/seen", "\n".join(identities))

    @property
    def recent_profiles(self) -> tuple[str, ...]:
        """Paths of profiles, the last used first."""
        return tuple(filter(None, (self._text("profiles/recent") or "").split("\n")))

    @recent_profiles.setter
    def recent_profiles(self, paths: tuple[str, ...]) -> None:
        self._settings.setValue("profiles/recent", "\n".join(paths))

    def add_profile(self, path: Path) -> None:
        """At the head of the recent ones; the oldest is dropped."""
        name = str(path.absolute())
        others = [one for one in self.recent_profiles if one != name]
        self.recent_profiles = (name, *others)[:MAX_RECENT]

    @property
    def recent_files(self) -> tuple[str, ...]:
        """Paths of files of any type, the last opened first."""
        return tuple(filter(None, (self._text("files/recent") or "").split("\n")))

    def add_file(self, path: Path) -> None:
        """At the head of the recent ones; the oldest is dropped."""
        name = str(path.absolute())
        names = (name, *(one for one in self.recent_files if one != name))[:MAX_RECENT]
        self._settings.setValue("files/recent", "\n".join(names))

    @property
    def who(self) -> str:
        """Who checked last."""
        return self._text("preflight/who") or ""

    @who.setter
    def who(self, name: str) -> None:
        self._settings.setValue("preflight/who", name)

    @property
    def aircraft(self) -> str:
        """The last aircraft."""
        return self._text("preflight/aircraft") or ""

    @aircraft.setter
    def aircraft(self, name: str) -> None:
        self._settings.setValue("preflight/aircraft", name)

    @property
    def geometry(self) -> QByteArray | None:
        return self._bytes("window/geometry")

    @geometry.setter
    def geometry(self, geometry: QByteArray) -> None:
        self._settings.setValue("window/geometry", geometry)

    @property
    def layout(self) -> QByteArray | None:
        """Where the docks are."""
        return self._bytes("window/layout")

    @layout.setter
    def layout(self, layout: QByteArray) -> None:
        self._settings.setValue("window/layout", layout)

    def _text(self, key: str) -> str | None:
        value = self._settings.value(key)
        return value if isinstance(value, str) and value else None

    def _bytes(self, key: str) -> QByteArray | None:
        value = self._settings.value(key)
        return value if isinstance(value, QByteArray) and not value.isEmpty() else None
