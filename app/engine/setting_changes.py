"""Readable settings, and the difference between two readings of them."""

from collections.abc import Mapping
from typing import NamedTuple

from protocol.catalogue import BY_NAME, SETTINGS, Command
from protocol.fields import Value

BOOT_COUNT = BY_NAME["boot_count"]
BOOTS = 256
"""It wraps to 0 after 255."""
READABLE_SETTINGS: tuple[Command, ...] = tuple(command for command in SETTINGS if command.reads_back)


class ChangedSetting(NamedTuple):
    """A setting that reads differently than before."""

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
