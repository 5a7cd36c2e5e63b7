"""Bounds for limits in a profile: it may be stricter, and softer down to a hard floor.

A limit softer than ours, or a setting outside the vendor's advice, is allowed within the bounds and shown beside the
verdict.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from app.limits.expectations import CheckLimits, Expectations
from app.safety.consequences import SHORT_FALL_S
from app.text.messages import UserMessage, message


class SoftLimit(NamedTuple):
    """`check`: id of its check. `is_maximum`: a higher value is softer."""

    check: str
    is_maximum: bool
    shown: str
    """For `str.format`, with the unit."""


SOFT_LIMITS: Mapping[str, SoftLimit] = MappingProxyType({
    "heartbeats_lost_max": SoftLimit("link_loss", is_maximum=True, shown="{:g}"),
    "round_trip_max_ms": SoftLimit("round_trip", is_maximum=True, shown="{:g} ms"),
    "tilt_max_deg": SoftLimit("tilt", is_maximum=True, shown="{:g}°"),
    "tilt_spread_max_deg": SoftLimit("tilt_spread", is_maximum=True, shown="{:g}°"),
    "acceleration_min_g": SoftLimit("acceleration", is_maximum=False, shown="{:g} g"),
    "acceleration_max_g": SoftLimit("acceleration", is_maximum=True, shown="{:g} g"),
    "acceleration_spread_max_g": SoftLimit("acceleration_spread", is_maximum=True, shown="{:g} g"),
    "cell_voltage_min_v": SoftLimit("cell_voltage", is_maximum=False, shown="{:.2f} V"),
})  # fmt: skip


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
    "light_threshold_v": SettingBound("light_threshold", 0.1, 25.5, 0.1, 25.5),
})  # fmt: skip


def softened(expectations: Expectations) -> Mapping[str, UserMessage]:
    """The advice, by id of the check, where the profile is softer."""
    found: dict[str, UserMessage] = {}
    ours = CheckLimits()
    for name, soft in SOFT_LIMITS.items():
        value, default = getattr(expectations.limits, name), getattr(ours, name)
        if value > default if soft.is_maximum else value < default:
            found[soft.check] = message(f"{'≤' if soft.is_maximum else '≥'} {soft.shown.format(default)}")
    for key, value in expectations.settings.items():
        bound = SETTING_BOUNDS.get(key)
        if bound is not None and not bound.advised_low <= value <= bound.advised_high:
            found[bound.check] = message(f"{bound.advised_low:g}–{bound.advised_high:g}")
    return found
