"""A flight as a module on the aircraft would have measured it, independent of the format of the log.

Times are seconds since the first sample, angles degrees, accelerations multiples of g.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from app.flights.judge import MAX_GAP_S
from app.text.messages import UserMessage, message
from app.text.user_error import UserError
from protocol.translatable import marked

if TYPE_CHECKING:
    from app.recordings.markers import Marker

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Progress = Callable[[float], object]
"""Called with the share of a long file that is read; may raise, to end reading."""
NO_PROGRESS: Final[Progress] = bool

REPORT_HZ: Final = 50
"""Rows per second of a `FlightLog` that no module measured; the rate of the simulated module."""


def unreadable(why: str) -> UserError:
    """`why` without a full stop, English, marked."""
    return UserError(marked("{why}."), why=message(why))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightLog:
    """One flight. All arrays have the same length, one row per report that a module would have sent.

    A pause in the log is a step in `time_s` of more than `MAX_GAP_S`.
    """

    name: str
    """Path of the file as given."""
    time_s: Floats
    """Ascending seconds since the first sample."""
    tilt_deg: Floats
    """0 level, 180 upside down; NaN where the attitude is unknown."""
    specific_force_g: Floats
    """Length of the specific force, 1 at rest; NaN where it is unknown or the sensor is implausible."""
    is_judged: Flags
    """False before the first arming and after the landing: these rows are not judged."""
    duration_s: float
    """From the first sample of the log to its last."""
    is_on_ground: Flags | None = None
    """None: the log does not say."""
    altitude_m: Floats | None = None
    """Above any fixed level; NaN where unknown. None: the log does not say."""
    resets: tuple["Marker", ...] = ()
    """Where the measuring module lost its state, or another one may have followed."""
    problems: tuple[UserMessage, ...] = field(default=())
    """What was left out or looks wrong."""

    @property
    def resets_s(self) -> tuple[float, ...]:
        return tuple(reset.time_s for reset in self.resets)

    @property
    def not_judged_s(self) -> float:
        """Time for which at least one trigger was not judged."""
        is_usable = self.is_judged & np.isfinite(self.tilt_deg) & np.isfinite(self.specific_force_g)
        steps = np.diff(self.time_s[is_usable])
        return max(0.0, round(self.duration_s - float(steps[steps <= MAX_GAP_S].sum()), 6))
