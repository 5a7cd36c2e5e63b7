"""Reads everything a verdict depends on, and compares two such readings.

The check reads it before and after measuring; the window reads it again every ten seconds while GO or READY stands.
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from app.engine.device import StatusSample
from app.engine.procedure import Procedure
from app.engine.setting_changes import changed_settings
from app.procedures.settings_reading import SettingsReading, read_settings
from app.procedures.who_is_there import Present, who_is_there
from app.settings.values import value_text
from app.text.messages import UserMessage, message
from protocol.catalogue import BOOT_COUNT, SETTINGS
from protocol.translatable import marked

REREAD_EVERY_S = 10.0

TITLES: Mapping[str, str] = {
    **{command.key: command.title for command in SETTINGS},
    BOOT_COUNT.key: BOOT_COUNT.title,
    "active": marked("Activation"),
    "triggered": marked("Triggered"),
    "charging": marked("Charging"),
    "cell_voltage_v": marked("Cell voltage"),
    "light_v": marked("Light"),
}


class StateReading(NamedTuple):
    settings: SettingsReading
    present: Present = Present()

    @property
    def status(self) -> StatusSample | None:
        return self.present.status

    @property
    def is_complete(self) -> bool:
        return self.settings.is_complete and self.present.contradiction is None


class StateChange(NamedTuple):
    """`shown`: the old and the new value, for people."""

    key: str
    shown: UserMessage


def read_state() -> Procedure[StateReading]:
    """Read the settings between two boot counts, then who is there. Sends queries only."""
    settings = yield from read_settings()
    if settings.is_silent:
        return StateReading(settings)
    return StateReading(settings, (yield from who_is_there()))


def changes_between(before: StateReading, after: StateReading) -> Iterator[StateChange]:
    """Values known in both that differ; except the activation, which people switch on purpose."""
    for changed in changed_settings(before.settings.values, after.settings.values):
        command, old, new = changed
        yield _change(command.key, value_text(command, old), value_text(command, new))
    boots = before.settings.boot_count, after.settings.boot_count
    if None not in boots and boots[0] != boots[1]:
        yield _change(BOOT_COUNT.key, str(boots[0]), str(boots[1]))
    if before.status is not None and after.status is not None and before.status.triggered != after.status.triggered:
        yield StateChange("triggered", UserMessage(TITLES["triggered"]))


def _change(key: str, before: str, after: str) -> StateChange:
    return StateChange(
        key, message("{what}: {before} → {after}", what=message(TITLES[key]), before=before, after=after)
    )
