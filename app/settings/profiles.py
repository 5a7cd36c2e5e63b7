"""Profile: target settings and limits for the modules of one airframe, stored as TOML.

    format = 1
    name = "Survey hexacopter"
    airframe = "H6"
    notes = "Bay sensor measured on 2026-01-02."

    [expectations]                  of the pre-flight check
    activated_by = "person"         or "aircraft": its flight controller activates the module, so the check ends at
                                    READY and says so

    [settings]                      any of the settings, with their units in the name
    attitude_threshold_deg = 60
    freefall_acceleration_g = 0.5

    [limits]                        of the pre-flight check; what is left out is the program's own limit
    cell_voltage_min_v = 3.8

    [tests]                         guided tests that must have passed, at most so many days ago
    tilt = 180                      tilt, free_fall, bay, charger, zero, link

    [[manual]]                      what a person looks at before the flight
    text = "Bridle free"
    required = true

Settings may also stand at the top, without a table. All errors of a file are told at once, with their lines. Keys that
nobody knows are refused, so that a misspelt threshold is not left out in silence; `expect_active` of older files is
read and has no effect: GO needs an active module anyway. See `app.settings.profile_file`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from types import MappingProxyType
from typing import NamedTuple

from app.engine.device import DeviceView, Known
from app.guided.results import GuidedKind
from protocol.catalogue import SERIAL_OUTPUT, SETTINGS, Command
from protocol.fields import Value
from protocol.translatable import marked

FORMAT = 1
LONGEST_NAME = 200
LONGEST_NOTES = 8_000
MOST_ITEMS = 40
MOST_TEST_DAYS = 3650

SETTINGS_BY_KEY: Mapping[str, Command] = MappingProxyType({command.key: command for command in SETTINGS})


class ActivatedBy(Enum):
    """Who activates the module before a flight; the value is the file's word."""

    PERSON = "person"
    AIRCRAFT = "aircraft"


class Bound(NamedTuple):
    """What a limit of the pre-flight check may be, ends included; beyond it a check would prove nothing. `why`: in
    English, translatable."""

    low: float
    high: float
    why: str


LIMITS: Mapping[str, Bound] = MappingProxyType({
    "heartbeats_lost_max": Bound(0, 2, marked("of 20; a worse line may lose a setting")),
    "round_trip_max_ms": Bound(1, 500, marked("after 1000 ms the module counts as offline")),
    "tilt_max_deg": Bound(0, 15, marked("beyond it one side fires late")),
    "tilt_spread_max_deg": Bound(0, 5, marked("a resting sensor wanders less")),
    "acceleration_min_g": Bound(0.8, 1.0, marked("at rest it is 1 g")),
    "acceleration_max_g": Bound(1.0, 1.2, marked("at rest it is 1 g")),
    "acceleration_spread_max_g": Bound(0, 0.4, marked("more noise can end a fall")),
    "cell_voltage_min_v": Bound(3.5, 4.2, marked("a lithium cell has 3.5 V to 4.2 V")),
})  # fmt: skip


@dataclass(frozen=True, slots=True)
class ManualLine:
    """Something a person looks at; `is_required`: skipped, it is a NO-GO."""

    text: str
    is_required: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Profile:
    """`settings` by key, in the field's unit; `limits` by name."""

    name: str
    airframe: str = ""
    notes: str = ""
    settings: Mapping[str, Value] = field(default_factory=dict)
    limits: Mapping[str, float] = field(default_factory=dict)
    manual: tuple[ManualLine, ...] = ()
    approved_fingerprint: str | None = None
    """Of a module that was found right with this profile: see `app.settings.fingerprint`."""
    is_light_inverted: bool = False
    """A calibration found that more light reads lower (E11)."""
    activated_by: ActivatedBy = ActivatedBy.PERSON
    tests_within_days: Mapping[GuidedKind, int] = field(default_factory=dict)
    """Guided tests that the pre-flight check demands, and how old the last one that passed may be."""


class Match(Enum):
    """How a row of the comparison stands; the value is its English, translatable word."""

    SAME = marked("same")
    DIFFERENT = marked("different")
    UNKNOWN = marked("unknown")
    NOT_IN_PROFILE = marked("not in the profile")


class ProfileRow(NamedTuple):
    """One setting, on the profile's side and on the module's. `stands` says how and when it is known."""

    command: Command
    wanted: Value | None
    stands: Known | None
    match: Match

    @property
    def is_worth_applying(self) -> bool:
        """Ticked at first: what differs, and what nobody knows."""
        return self.match in (Match.DIFFERENT, Match.UNKNOWN)


def compare(profile: Profile, device: DeviceView, now: float) -> tuple[ProfileRow, ...]:
    """All settings in the catalogue's order. What is stale on the module counts as unknown."""
    return tuple(_row(command, profile, device, now) for command in SETTINGS)


def _row(command: Command, profile: Profile, device: DeviceView, now: float) -> ProfileRow:
    wanted = profile.settings.get(command.key)
    stands = device.known(command.key, now)
    if wanted is None:
        return ProfileRow(command, None, stands, Match.NOT_IN_PROFILE)
    if stands is None or stands.is_stale:
        return ProfileRow(command, wanted, stands, Match.UNKNOWN)
    return ProfileRow(command, wanted, stands, Match.SAME if stands.value == wanted else Match.DIFFERENT)


def profile_of(device: DeviceView, now: float, *, name: str) -> Profile:
    """The module's present settings as a profile: only what is known and in no doubt, and not the serial output, which
    the program itself switches."""
    known = {key: device.fresh(key, now) for key in SETTINGS_BY_KEY if key != SERIAL_OUTPUT.key}
    return Profile(name=name, settings={key: value for key, value in known.items() if value is not None})
