"""Limits: the bounds of a profile, what in it is softer than advised, and whether a value is out of its limit.

A limit softer than ours, or a setting outside the vendor's advice, is allowed within the bounds and shown beside the
verdict.
"""

from collections.abc import Mapping
from enum import Enum
from types import MappingProxyType
from typing import NamedTuple

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


SETTING_BOUNDS: Mapping[str, SettingBound] = MappingProxyType(
    {
        "attitude_threshold_deg": SettingBound("attitude_threshold", "{:g}–{:g}°", 55, 90, 30, 90),
        "freefall_acceleration_g": SettingBound("freefall_acceleration", "{:g}–{:g} g", 0.1, 0.6, 0.1, 0.8),
        "freefall_time_s": SettingBound("freefall_time", "{:.2f}–{:.2f} s", SHORT_FALL_S, 2.55, 0.2, 2.55),
        "light_threshold_v": SettingBound("light_threshold", "{:g}–{:g} V", 0.1, 25.4, 0.1, 25.5),
    }
)


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


CELL_ABOVE_V = 0.05
"""More than two steps above the highest cell voltage it is not the cell's."""


class OutOfLimit(Enum):
    """The value is English, translatable."""

    CELL_LOW = marked("low")
    CELL_HIGH = marked("too high")
    BAY_OPEN = marked("bay open")


class Outside(NamedTuple):
    """`limit`: with its unit."""

    fault: OutOfLimit
    limit: str

    def beside(self, value: str) -> str:
        return tr("{value} (!) {fault}, limit {limit}", value=value, fault=tr(self.fault.value), limit=self.limit)


class LimitsInUse:
    """The limits of the chosen profile; what it does not say is the program's own."""

    def __init__(self) -> None:
        self.profile = NO_PROFILE

    def use(self, profile: Profile | None) -> None:
        self.profile = profile or NO_PROFILE


def least_cell_text(profile: Profile) -> str:
    """Return the least cell voltage with all its decimals, so that no reading below it looks like it."""
    least = profile.limit("cell_voltage_min_v")
    return f"{least:.2f} V" if round(least, 2) == least else f"{least:g} V"


def cell_outside(volts: float, profile: Profile, *, is_charging: bool | None) -> Outside | None:
    """Judge the cell voltage. With external power the charger's voltage is read, which is above the cell's: too low is
    too low then, too."""
    if volts < profile.limit("cell_voltage_min_v"):
        return Outside(OutOfLimit.CELL_LOW, least_cell_text(profile))
    if is_charging is False and volts > HIGHEST_CELL_V + CELL_ABOVE_V:
        return Outside(OutOfLimit.CELL_HIGH, f"{HIGHEST_CELL_V:.2f} V")
    return None


def bay_outside(light_v: float, threshold_v: float, *, is_inverted: bool = False) -> Outside | None:
    """`is_inverted`: a calibration found that more light reads lower."""
    is_dark = light_v > threshold_v if is_inverted else light_v < threshold_v
    return None if is_dark else Outside(OutOfLimit.BAY_OPEN, f"{threshold_v:.1f} V")


def value_outside(key: str, conversation: ConversationView, now: float, profile: Profile) -> Outside | None:
    """Judge the module's last value; None also if the value or its limit is unknown."""
    values = {name: known.value for name in (key, "charging") if (known := conversation.known(name, now)) is not None}
    threshold = conversation.fresh("light_threshold_v", now)
    return outside_of(key, values if threshold is None else values | {"light_threshold_v": threshold}, profile)


def outside_of(key: str, values: Mapping[str, Value], profile: Profile) -> Outside | None:
    measured = values.get(key)
    if measured is None:
        return None
    value = round(float(measured), 3)  # recordings keep four bytes of it: 3.7999999 is 3.80
    if key == "cell_voltage_v":
        charging = values.get("charging")
        return cell_outside(value, profile, is_charging=None if charging is None else charging is True)
    if key == "light_v":
        threshold = values.get("light_threshold_v")
        if threshold is None:
            return None
        return bay_outside(value, float(threshold), is_inverted=profile.is_light_inverted)
    return None


def record_outside(record: TriggerRecord) -> Outside | None:
    """Judge the cell voltage in a trigger record by the program's own limits; None for an implausible record, which is
    marked as such."""
    if record.implausible:
        return None
    return cell_outside(record.cell_voltage_v, NO_PROFILE, is_charging=record.charging)
