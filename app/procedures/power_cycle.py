"""Checks whether settings survive a power cycle, which the table leaves open (E15).

    boot count -> wait while a person switches it off and on -> boot count again, one more -> read everything back

A restart shows in two heartbeats and is proven by the boot count. If the adapter loses its power with the module, the
procedure ends with the port.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from app.engine.identity import IdentityEvidence, is_exchanged
from app.engine.procedure import EngineView, Inspect, Pause, Procedure, Report
from app.engine.setting_changes import BOOT_COUNT, BOOTS
from app.procedures.write import RESTART_SHOWS_S, read_back
from protocol.catalogue import SETTINGS, Command
from protocol.fields import Value
from protocol.translatable import marked

MAX_WAIT_S = 120.0
POLL_EVERY_S = 1.0


class Retention(Enum):
    """What happened to a setting. If it is unknown the value says why, in translatable English."""

    RETAINED = "kept"
    LOST = "lost"
    UNREADABLE = marked("unknown (cannot be read)")
    NOT_READ = marked("could not be read back")


class Ending(Enum):
    RESTARTED = "restarted"
    """Seen and proven: exactly one more boot."""
    SEVERAL = "several restarts"
    """More than one; the readings are still valid."""
    UNPROVEN = "unproven"
    """Its heartbeats were received, but the boot count did not increase: the power may not have been off."""
    NOT_SEEN = "not seen"
    """It was not switched off and on in time; nothing is known."""


class SettingRetention(NamedTuple):
    """`read_back`: the reading after the restart."""

    target: Value
    result: Retention
    read_back: Value | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerCycleResult:
    """`stamps` by key; empty where no restart was seen."""

    ending: Ending
    stamps: Mapping[str, SettingRetention]
    boots_before: int | None
    boots_after: int | None = None

    @property
    def is_fine(self) -> bool:
        """Whether everything that can be read was kept."""
        is_seen = self.ending in (Ending.RESTARTED, Ending.SEVERAL)
        return is_seen and all(
            stamp.result in (Retention.RETAINED, Retention.UNREADABLE) for stamp in self.stamps.values()
        )


def survives_power_cycle(
    written: Mapping[str, Value], *, longest_wait_s: float = MAX_WAIT_S
) -> Procedure[PowerCycleResult]:
    """`written`: the values by key."""
    before: EngineView = yield Inspect()
    boots_before = (yield from read_back(BOOT_COUNT)).raw
    boots: int | None = None
    while True:
        view: EngineView = yield Inspect()
        waited_s = view.now - before.now
        if waited_s > longest_wait_s:
            return PowerCycleResult(ending=Ending.NOT_SEEN, stamps={}, boots_before=boots_before)
        yield Report(int(waited_s), int(longest_wait_s), marked("Switch the module off and on"))
        has_restarted = view.device.restarts != before.device.restarts
        boots = (yield from read_back(BOOT_COUNT)).raw
        if boots is not None and (has_restarted or (boots_before is not None and boots != boots_before)):
            break
        yield Pause(POLL_EVERY_S)
    if is_exchanged(IdentityEvidence(boots_before), IdentityEvidence(boots)):  # another module was plugged in
        return PowerCycleResult(ending=Ending.UNPROVEN, stamps={}, boots_before=boots_before, boots_after=boots)
    yield Pause(RESTART_SHOWS_S)  # until the restart's second heartbeat has passed
    stamps: dict[str, SettingRetention] = {}
    for command in SETTINGS:
        if command.key in written and command.key != "baud_rate":
            if not command.reads_back:
                stamps[command.key] = SettingRetention(written[command.key], Retention.UNREADABLE)
                continue
            back = yield from read_back(command)
            stamps[command.key] = _stamp(command, written[command.key], back.raw)
    return PowerCycleResult(
        ending=_ending(boots_before, boots), stamps=stamps, boots_before=boots_before, boots_after=boots
    )


def _stamp(command: Command, target: Value, raw: int | None) -> SettingRetention:
    if raw is None or command.write is None:
        return SettingRetention(target, Retention.NOT_READ)
    value = command.write.decode(raw)
    return SettingRetention(target, Retention.RETAINED if value == target else Retention.LOST, value)


def _ending(before: int | None, after: int | None) -> Ending:
    if before is None or after is None:
        return Ending.UNPROVEN
    boots = (after - before) % BOOTS
    if boots == 0:
        return Ending.UNPROVEN
    return Ending.RESTARTED if boots == 1 else Ending.SEVERAL
