"""Readable settings, the difference between two readings of them, and which request changes which value."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from protocol.catalogue import ACTIVATION, BY_NAME, SETTINGS, Command, Request
from protocol.fields import Value

BOOTS = 256
"""It wraps to 0 after 255."""
READABLE_SETTINGS: tuple[Command, ...] = tuple(command for command in SETTINGS if command.reads_back)


class ChangedSetting(NamedTuple):
    command: Command
    before: Value
    after: Value


def changed_settings(before: Mapping[str, Value], after: Mapping[str, Value]) -> tuple[ChangedSetting, ...]:
    """The differences, in the order of the catalogue; a key missing on one side is not compared."""
    return tuple(
        ChangedSetting(command, before[command.key], after[command.key])
        for command in READABLE_SETTINGS
        if command.key in before and command.key in after and before[command.key] != after[command.key]
    )


_CHANGED_BY_ACTS: Mapping[Command, str] = MappingProxyType(
    {ACTIVATION: "active", BY_NAME["deploy"]: "triggered", BY_NAME["zero_sensor"]: "tilt_deg"}
)
ACKNOWLEDGED_KEYS = frozenset(command.key for command in SETTINGS) - {"baud_rate"} | {"active"}
"""Values that an acknowledgement provides."""
UNREADABLE = frozenset(command.key for command in SETTINGS if not command.reads_back) - {"baud_rate"}
"""E8: settings that cannot be read, so a restart, or a module that may have been exchanged, makes them unknown."""


def key_changed_by(request: Request) -> str | None:
    """The key of the value that this request changes, or None."""
    command = request.command
    if request.is_repeatable:
        return None
    return command.key if command.is_setting else _CHANGED_BY_ACTS.get(command)
