"""Handles a set in the simulated module: stored, clamped, refused or ignored, and what is acknowledged."""

from typing import NamedTuple

from app.simulator.quirks import Acknowledge, Quirks
from protocol.catalogue import BY_NAME, Command

ACCEPTED = 0x01
FAILED = 0x00

_CLAMPS = {
    BY_NAME["attitude_threshold"]: range(55, 91),
    BY_NAME["freefall_acceleration"]: range(1, 7),
    BY_NAME["freefall_time"]: range(50, 256),
    BY_NAME["light_threshold"]: range(1, 34),
}
"""Ranges that the vendor advises, or that the sensor can measure."""


class StoredSettings(NamedTuple):
    value: int
    """New byte of the setting."""
    acknowledgement: int
    """D4 of the reply."""


def clamped(command: Command, raw: int) -> int:
    """The nearest byte within the advised range."""
    allowed = _CLAMPS.get(command, range(256))
    return min(max(raw, allowed.start), allowed.stop - 1)


def store_setting(command: Command, wanted: int, old: int, quirks: Quirks) -> StoredSettings:
    """The outcome of a set of `command` from `old` to `wanted` (bytes)."""
    by_one = quirks.ack is Acknowledge.ONE and command.acknowledged_by_one
    if quirks.refuses and wanted != old:
        return StoredSettings(old, FAILED if by_one else old)
    value = clamped(command, wanted) if quirks.clamps else wanted
    return StoredSettings(value if quirks.keeps else old, ACCEPTED if by_one else value)
