"""Snapshots of a module's settings, for restoring initial values."""

from collections.abc import Mapping
from dataclasses import dataclass

from app.engine.device import DeviceView
from protocol.catalogue import SERIAL_OUTPUT, SETTINGS
from protocol.fields import Value, ValueRefused
from protocol.translatable import marked

AS_FOUND = marked("as found, before the first change")


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """`settings`: by key, in the field's unit, without unknown ones. `reason`: English, translatable."""

    settings: Mapping[str, Value]
    boot_count: int | None = None
    reason: str = AS_FOUND


def snapshot_of(device: DeviceView, now: float, *, reason: str = AS_FOUND) -> Snapshot:
    """The settings that are known and not stale at `now`, except the serial output, which the program itself
    switches."""
    settings = {
        command.key: value
        for command in SETTINGS
        if command is not SERIAL_OUTPUT and (value := device.fresh(command.key, now)) is not None
    }
    boots = device.fresh("boot_count", now)
    return Snapshot(settings=settings, boot_count=None if boots is None else int(boots), reason=reason)


def restorable(settings: Mapping[str, object]) -> dict[str, Value]:
    """The valid ones of `settings` (from a file)."""
    found: dict[str, Value] = {}
    for command in SETTINGS:
        value = settings.get(command.key)
        if command.write is None or not isinstance(value, bool | int | float):
            continue
        try:
            command.write.encode(value)
        except ValueRefused:
            continue
        found[command.key] = value
    return found
