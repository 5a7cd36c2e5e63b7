"""Detects settings that changed without being written here."""

from collections.abc import Iterable, Mapping

from app.engine.device import DeviceView, How
from app.engine.setting_changes import READABLE_SETTINGS, ChangedSetting
from protocol.fields import Value


class SettingsWatch:
    """Compares each reading with the last one. Belongs to one thread."""

    def __init__(self) -> None:
        self._held: dict[str, Value] = {}
        """The expected value of each setting, by key."""
        self._changed: dict[str, ChangedSetting] = {}

    @property
    def changed(self) -> Mapping[str, ChangedSetting]:
        """By key, until the setting is written, accepted, or reads as expected again."""
        return self._changed

    def observe(self, device: DeviceView, now: float) -> None:
        for command in READABLE_SETTINGS:
            key = command.key
            known = device.known(key, now)
            if known is None or known.is_stale or known.how is not How.READ:
                continue
            held = self._held.setdefault(key, known.value)
            if known.value == held:
                self._changed.pop(key, None)
            elif key not in self._changed or self._changed[key].after != known.value:
                self._changed[key] = ChangedSetting(command, held, known.value)

    def accept(self, keys: Iterable[str] | None = None) -> None:
        """Makes the next reading of these settings (None: of all) the expected one."""
        for key in list(self._held) if keys is None else list(keys):
            self._held.pop(key, None)
            self._changed.pop(key, None)
