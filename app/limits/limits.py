"""Bounds for settings in a profile, and what in it is softer than advised.

A limit softer than ours, or a setting outside the vendor's advice, is allowed within the bounds and shown beside the
verdict.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from app.safety.consequences import SHORT_FALL_S
from app.settings.profiles import LIMITS, Profile
from app.text.messages import UserMessage, joined, message


class SettingBound(NamedTuple):
    """Inclusive. `advised_*`: the vendor's advice, or ours if there is none. `low`, `high`: hard bounds of profiles."""

    check: str
    advised_low: float
    advised_high: float
    low: float
    high: float


SETTING_BOUNDS: Mapping[str, SettingBound] = MappingProxyType({
    "attitude_threshold_deg": SettingBound("attitude_threshold", 55, 90, 30, 90),
    "freefall_acceleration_g": SettingBound("freefall_acceleration", 0.1, 0.6, 0.1, 0.8),
    "freefall_time_s": SettingBound("freefall_time", SHORT_FALL_S, 2.55, 0.2, 2.55),
    "light_threshold_v": SettingBound("light_threshold", 0.1, 25.4, 0.1, 25.5),
})  # fmt: skip


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
            advice[bound.check] = [message(f"{bound.advised_low:g}–{bound.advised_high:g}")]
    return {check: joined(texts) for check, texts in advice.items()}
