"""Channels of a log file, each with its own times, before they are assembled to a flight."""

from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from app.flights.flight_log import Flags, Floats
from app.text.messages import UserMessage

STANDARD_GRAVITY_M_S2: Final = 9.80665


class Channel(NamedTuple):
    """Unchecked samples of one quantity; times are seconds of the log's clock."""

    time_s: Floats
    values: Floats


class FlagChannel(NamedTuple):
    """A flag that holds until the next row."""

    time_s: Floats
    values: Flags
    is_changes: bool = False
    """Each row is a change, so before the first row the flag had the opposite value."""


@dataclass(slots=True, kw_only=True)
class RawLog:
    """Candidates of a quantity are in order of preference."""

    name: str
    tilts_deg: list[Channel] = field(default_factory=list)
    forces_g: list[Channel] = field(default_factory=list)
    """Length of the specific force, one channel for each sensor."""
    altitude_m: Channel | None = None
    armed: FlagChannel | None = None
    on_ground: FlagChannel | None = None
    span_s: tuple[float, float] | None = None
    """First and last time in the file, where also those without a value are known."""
    lost_end_s: float = 0.0
    """Estimate of the time that the damaged end of the file would have held."""
    joins_s: Floats = field(default_factory=lambda: np.empty(0))
    """Where another flight of the same file begins: the pause before it is no gap."""
    problems: list[UserMessage] = field(default_factory=list)

    def seconds_of(self, lost_bytes: int, all_bytes: int) -> float:
        """Estimates how long the flight controller logs for that many bytes, from what was read of the file."""
        sensed = [*self.tilts_deg, *self.forces_g]
        times_s = np.concatenate([np.empty(0), *(channel.time_s for channel in sensed)])
        times_s = times_s[np.isfinite(times_s)]
        if not len(times_s) or lost_bytes >= all_bytes:
            return 0.0
        # A damaged time must not stretch it: the first and the last twentieth do not count.
        early_s, late_s = np.quantile(times_s, (0.05, 0.95))
        return float(late_s - early_s) / 0.9 * lost_bytes / (all_bytes - lost_bytes)


def tilt_of_quaternion(w: Floats, x: Floats, y: Floats, z: Floats) -> Floats:
    """Degrees between the body's and the world's vertical; NaN where the quaternion is not normalised."""
    length = np.sqrt(w * w + x * x + y * y + z * z)
    tilt = np.degrees(2 * np.arctan2(np.hypot(x, y), np.hypot(w, z)))
    return np.where(np.abs(length - 1) <= 0.1, tilt, np.nan)


def tilt_of_roll_and_pitch(roll_deg: Floats, pitch_deg: Floats) -> Floats:
    """Degrees between the body's and the world's vertical."""
    product = np.cos(np.radians(roll_deg)) * np.cos(np.radians(pitch_deg))
    tilt: Floats = np.degrees(np.arccos(np.clip(product, -1, 1)))
    return tilt


def force_of_axes(x_m_s2: Floats, y_m_s2: Floats, z_m_s2: Floats) -> Floats:
    """Length in g."""
    force: Floats = np.sqrt(x_m_s2 * x_m_s2 + y_m_s2 * y_m_s2 + z_m_s2 * z_m_s2) / STANDARD_GRAVITY_M_S2
    return force
