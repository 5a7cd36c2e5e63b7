"""Snapshots of a module's settings, for restoring initial values."""

from collections.abc import Mapping
from dataclasses import dataclass

from protocol.catalogue import SETTINGS
from protocol.fields import Value, ValueRefused


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """`settings`: by key, in the field's unit, without unknown ones."""

    settings: Mapping[str, Value]
    boot_count: int | None = None


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
