"""Limits: the bounds of a profile, what in it is softer than advised, and whether a value is out of its limit.

A limit softer than ours, or a setting outside the vendor's advice, is allowed within the bounds and shown beside the
verdict.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Final, NamedTuple

from app.engine.conversation import ConversationView
from app.safety.consequences import SHORT_FALL_S
from app.settings.profiles import LIMITS, NO_PROFILE, Profile
from app.text.i18n import tr
from app.text.messages import UserMessage, joined, message
from protocol.fields import Value
from protocol.messages import HIGHEST_CELL_V, TriggerRecord
from protocol.translatable import marked


class SettingBound(NamedTuple):
    """Inclusive. `advised_*`: the vendor's advice, or ours if there is none, and how that is `shown`. `low`, `high`:
    hard bounds of profiles."""

    check: str
    shown: str
    advised_low: float
    advised_high: float
    low: float
    high: float

    @property
    def advice(self) -> UserMessage:
        return message(self.shown.format(self.advised_low, self.advised_high))


SETTING_BOUNDS: Final[Mapping[str, SettingBound]] = {
    "attitude_threshold_deg": SettingBound("attitude_threshold", "{:g}–{:g}°", 55, 90, 30, 90),
    "freefall_acceleration_g": SettingBound("freefall_acceleration", "{:g}–{:g} g", 0.1, 0.6, 0.1, 0.8),
    "freefall_time_s": SettingBound("freefall_time", "{:.2f}–{:.2f} s", SHORT_FALL_S, 2.55, 0.2, 2.55),
    "light_threshold_v": SettingBound("light_threshold", "{:g}–{:g} V", 0.1, 25.4, 0.1, 25.5),
}


def softened(profile: Profile) -> Mapping[str, UserMessage]:
    """The advice, by id of the check, where the profile is softer."""
    advice: dict[str, list[UserMessage]] = {}
    for name, limit in LIMITS.items():
        value = profile.limit(name)
        if value > limit.usual if limit.is_maximum else value < limit.usual:
            text = message(f"{'≤' if limit.is_maximum else '≥'} {limit.shown.format(limit.usual)}")
            advice.setdefault(limit.check, []).append(text)
    for key, value in profile.settings.items():
        bound = SETTING_BOUNDS.get(key)
        if bound is not None and not bound.advised_low <= value <= bound.advised_high:
            advice[bound.check] = [bound.advice]
    return {check: joined(texts) for check, texts in advice.items()}


# More than two steps above the highest cell voltage it is not the cell's.
CELL_ABOVE_V = 0.05


class OutOfLimit(Enum):
    """The value is English, translatable."""

    CELL_LOW = marked("low")
    CELL_HIGH = marked("too high")


class Outside(NamedTuple):
    """`limit`: with its unit."""

    fault: OutOfLimit
    limit: str

    def beside(self, value: str) -> str:
        return tr("{value} (!) {fault}, limit {limit}", value=value, fault=tr(self.fault.value), limit=self.limit)


@dataclass
class LimitsInUse:
    """The limits of the chosen profile; what it does not say is the program's own."""

    profile: Profile = NO_PROFILE


def least_cell_text(profile: Profile) -> str:
    """Return the least cell voltage with all its decimals, so that no reading below it looks like it."""
    least = profile.limit("cell_voltage_min_v")
    return f"{least:.2f} V" if round(least, 2) == least else f"{least:g} V"


# Recordings keep four bytes of a value: 3.7999999 is 3.80.
_DECIMALS = 3


def cell_outside(volts: float, profile: Profile, *, is_charging: Value | None) -> Outside | None:
    """Judge the cell voltage. With external power the charger's voltage is read, which is above the cell's: too low is
    too low then, too."""
    volts = round(volts, _DECIMALS)
    if volts < profile.limit("cell_voltage_min_v"):
        return Outside(OutOfLimit.CELL_LOW, least_cell_text(profile))
    if is_charging is False and volts > HIGHEST_CELL_V + CELL_ABOVE_V:
        return Outside(OutOfLimit.CELL_HIGH, f"{HIGHEST_CELL_V:.2f} V")
    return None


def last_cell_outside(conversation: ConversationView, now: float, profile: Profile) -> Outside | None:
    """Judge the module's last cell voltage; None also if it is unknown."""
    voltage, charging = conversation.known("cell_voltage_v", now), conversation.known("charging", now)
    if voltage is None:
        return None
    return cell_outside(float(voltage.value), profile, is_charging=None if charging is None else charging.value)


def record_outside(record: TriggerRecord) -> Outside | None:
    """Judge the cell voltage in a trigger record by the program's own limits; None for an implausible record, which is
    marked as such."""
    if record.implausible:
        return None
    return cell_outside(record.cell_voltage_v, NO_PROFILE, is_charging=record.charging)


def is_bay_open(light_v: float, threshold_v: float, *, is_inverted: bool) -> bool:
    """`is_inverted`: a calibration found that more light reads lower."""
    light_v = round(light_v, _DECIMALS)
    return light_v <= threshold_v if is_inverted else light_v >= threshold_v
