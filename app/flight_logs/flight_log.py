"""A flight as a module on the aircraft would have felt it, whatever wrote the log.

Times are seconds since the first sample of the log. Angles are degrees, accelerations multiples of g.
"""

from dataclasses import dataclass, field
from enum import Enum
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from app.firing.judge import LONGEST_GAP_S
from app.text.messages import UserMessage
from protocol.translatable import marked

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

REPORT_HZ: Final = 50
"""Rows a second in a `FlightLog` that no module measured. The vendor names no rate; it is the simulated module's."""


class LogFormat(Enum):
    """Kind of file; the value is its name for people."""

    ULOG = "PX4 ULog"
    DATAFLASH = "ArduPilot DataFlash"
    CSV = "CSV"
    MCAP = "MCAP"
    RECORDING = marked("recording")


class LogUnreadable(Exception):
    """Nothing of the file can be judged; `why` says so."""

    def __init__(self, why: UserMessage) -> None:
        super().__init__(why)  # as the only argument, so that it survives the way between processes
        self.why = why

    def __str__(self) -> str:
        return self.why.in_english()


class ModeChange(NamedTuple):
    """The flight mode from this time on."""

    time_s: float
    name: str
    """As the flight controller calls it: "LOITER", "mode 5"."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightLog:
    """One flight. All arrays have the same length, one row for each report that a module would have sent.

    Rows exist only where the log has samples: a pause in the log is a step in `time_s` of more than `LONGEST_GAP_S`.
    """

    name: str
    """Path of the file, as it was given."""
    format: LogFormat
    time_s: Floats
    """Ascending seconds since the first sample."""
    tilt_deg: Floats
    """0 level, 180 upside down; NaN where the attitude is not known."""
    specific_force_g: Floats
    """Length of the specific force, 1 at rest; NaN where it is not known or the sensor is not to be believed."""
    is_judged: Flags
    """False before the first arming and after the landing: nothing is claimed about these rows."""
    duration_s: float
    """From the first sample of the log to its last."""
    is_armed: Flags | None = None
    """None: the log does not say."""
    is_on_ground: Flags | None = None
    """None: the log does not say."""
    altitude_m: Floats | None = None
    """Above any fixed level; NaN where it is not known. None: the log does not say."""
    modes: tuple[ModeChange, ...] = ()
    """In order of time."""
    resets_s: tuple[float, ...] = ()
    """Times at which the module that measured it restarted, and forgot everything."""
    has_module_resolution: bool = False
    """Measured by a module: values are its reports already, whole degrees and tenths of g."""
    problems: tuple[UserMessage, ...] = field(default=())
    """What was left out or looks wrong, for people and for JSON (`in_words`, `in_english`)."""

    @property
    def judged_s(self) -> float:
        """Time that both triggers were judged for."""
        is_usable = self.is_judged & np.isfinite(self.tilt_deg) & np.isfinite(self.specific_force_g)
        return covered_s(self.time_s[is_usable])

    @property
    def not_judged_s(self) -> float:
        """Time of the log that nothing, or not everything, is claimed about."""
        return max(0.0, round(self.duration_s - self.judged_s, 6))


def covered_s(time_s: Floats) -> float:
    """Sum of the steps between these times that are no pauses."""
    steps = np.diff(time_s)
    return float(steps[steps <= LONGEST_GAP_S].sum())
