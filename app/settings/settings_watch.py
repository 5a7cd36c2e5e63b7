"""Detects settings that changed without being written here."""

from collections.abc import Iterable
from typing import NamedTuple

from app.engine.device import DeviceView, How
from app.engine.setting_changes import READABLE_SETTINGS, ChangedSetting, key_changed_by
from protocol.events import Event, Sent
from protocol.fields import Value


class _Write(NamedTuple):
    """What this program sent last. `at`: monotonic seconds."""

    value: Value
    at: float


class SettingsWatch:
    """Compares each reading with the last one. Of one module on one connection; belongs to one thread."""

    def __init__(self) -> None:
        self._held: dict[str, Value] = {}
        """The expected value of each setting, by key."""
        self._written: dict[str, _Write] = {}
        self.changed: dict[str, ChangedSetting] = {}
        """By key, until the setting is written, accepted, or reads as expected again."""

    def note_writes(self, events: Iterable[Event]) -> None:
        """Whatever part of the program sent them: what the module then reads is no foreign change."""
        for event in events:
            if isinstance(event, Sent) and event.request.command.write is not None:
                key = key_changed_by(event.request)
                if key is not None:
                    self.accept((key,))
                    self._written[key] = _Write(event.request.command.write.decode(event.request.data), event.at)

    def observe(self, device: DeviceView, now: float) -> None:
        for command in READABLE_SETTINGS:
            key = command.key
            known, written = device.known(key, now), self._written.get(key)
            if known is None or known.is_stale or known.how is not How.READ:
                continue
            if written is not None and known.at <= written.at:
                continue
            if written is not None and known.value == written.value:
                self._held.pop(key, None)
            held = self._held.setdefault(key, known.value)
            if known.value == held:
                self.changed.pop(key, None)
            elif key not in self.changed or self.changed[key].after != known.value:
                self.changed[key] = ChangedSetting(command, held, known.value)

    def expect(self, key: str, value: Value) -> None:
        """The module was read back to hold it: a later reading of another value is a change."""
        self._held[key] = value

    def accept(self, keys: Iterable[str] | None = None) -> None:
        """Makes the next reading of these settings (None: of all) the expected one."""
        if keys is None:
            self._held, self._written, self.changed = {}, {}, {}
            return
        for key in list(keys):
            self._held.pop(key, None)
            self.changed.pop(key, None)
