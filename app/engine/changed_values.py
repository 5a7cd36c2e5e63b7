"""Maps a request to the value of the module that it changes."""

from collections.abc import Mapping
from types import MappingProxyType

from protocol.catalogue import ACTIVATION, BY_NAME, SETTINGS, Command, Request

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
