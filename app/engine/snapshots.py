"""Snapshots of a module's settings, for restoring initial values."""

from collections.abc import Mapping
from dataclasses import dataclass

from app.engine.device import DeviceView
from protocol.catalogue import SERIAL_OUTPUT, SETTINGS
from protocol.fields import Value, ValueRefused


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """`settings`: by key, in the field's unit, without unknown ones."""

    settings: Mapping[str, Value]
    boot_count: int | None = None


def fresh_settings(device: DeviceView, now: float) -> dict[str, Value]:
    """The settings that are known and not stale at `now`, except the serial output, which the program itself
    switches."""
    return {
        command.key: value
        for command in SETTINGS
        if command is not SERIAL_OUTPUT and (value := device.fresh(command.key, now)) is not None
    }


def snapshot_of(device: DeviceView, now: float) -> Snapshot:
    boots = device.fresh("boot_count", now)
    return Snapshot(settings=fresh_settings(device, now), boot_count=None if boots is None else int(boots))


def restorable(settings: Mapping[str, object]) -> dict[str, Value]:
    """The valid ones of `settings` (from a file)."""
    valid: dict[str, Value] = {}
    for command in SETTINGS:
        value = settings.get(command.key)
        if command.write is None or not isinstance(value, bool | int | float):
            continue
        try:
            command.write.encode(value)
        except ValueRefused:
            continue
        valid[command.key] = value
    return valid
