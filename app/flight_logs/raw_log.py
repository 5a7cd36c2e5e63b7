"""What a reader finds in a file, before it becomes a flight: channels with clocks of their own."""

from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from app.flight_logs.flight_log import Flags, Floats, LogFormat, ModeChange
from app.text.messages import UserMessage

STANDARD_GRAVITY_M_S2: Final = 9.80665
MOST_MODES: Final = 10_000


class Channel(NamedTuple):
    """Samples of one quantity as they stand in the file, unchecked. Times are seconds of the log's clock."""

    time_s: Floats
    values: Floats


class FlagChannel(NamedTuple):
    """A flag that holds until the next row."""

    time_s: Floats
    values: Flags
    is_changes: bool = False
    """Each row says that it has just changed: before the first one it was the other way round, not the same."""


@dataclass(slots=True, kw_only=True)
class RawLog:
    """Several candidates of a quantity stand in the order in which they are preferred."""

    name: str
    format: LogFormat
    tilts_deg: list[Channel] = field(default_factory=list)
    forces_g: list[Channel] = field(default_factory=list)
    """Length of the specific force, one channel for each sensor."""
    altitude_m: Channel | None = None
    armed: FlagChannel | None = None
    on_ground: FlagChannel | None = None
    modes: list[ModeChange] = field(default_factory=list)
    """On the log's clock."""
    problems: list[UserMessage] = field(default_factory=list)


def tilt_of_quaternion(w: Floats, x: Floats, y: Floats, z: Floats) -> Floats:
    """Degrees between the body's down and the world's; NaN where the quaternion has not the length 1."""
    length = np.sqrt(w * w + x * x + y * y + z * z)
    tilt = np.degrees(2 * np.arctan2(np.hypot(x, y), np.hypot(w, z)))
    return np.where(np.abs(length - 1) <= 0.1, tilt, np.nan)


def tilt_of_roll_and_pitch(roll_deg: Floats, pitch_deg: Floats) -> Floats:
    """Degrees between the body's down and the world's."""
    product = np.cos(np.radians(roll_deg)) * np.cos(np.radians(pitch_deg))
    tilt: Floats = np.degrees(np.arccos(np.clip(product, -1, 1)))
    return tilt


def force_of_axes(x_m_s2: Floats, y_m_s2: Floats, z_m_s2: Floats) -> Floats:
    """Length in g."""
    force: Floats = np.sqrt(x_m_s2 * x_m_s2 + y_m_s2 * y_m_s2 + z_m_s2 * z_m_s2) / STANDARD_GRAVITY_M_S2
    return force
