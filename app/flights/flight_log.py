"""A flight as a module on the aircraft would have measured it, independent of the format of the log.

Times are seconds since the first sample, angles degrees, accelerations multiples of g.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from app.flights.judge import MAX_GAP_S
from app.flights.raw_log import Flags, Floats, Places
from app.text.messages import UserMessage

if TYPE_CHECKING:
    from app.recordings.markers import Marker

# Begin and end of each in seconds, shape (number, 2), ascending.
Spans = NDArray[np.float64]

REPORT_HZ: Final = 50
"""Rows per second of a `FlightLog` that no module measured; the rate of the simulated module."""
TILT_GAP_S: Final = 0.2
"""The shortest tilt that fires under either reading of the rule. A longer pause between two attitudes may hide one."""
GAP_TOLERANCE_S: Final = 0.01
"""Half a report: clocks of logs jitter."""
SHORTEST_LOG_S: Final = 1.0
LONGEST_LOG_S: Final = 24 * 3600.0
"""No flight is shorter or longer: where a log is, its clock or the unit of its times is wrong."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightLog:
    """One flight. All arrays have the same length, one row per report that a module would have sent.

    Where nothing was logged there are no rows.
    """

    # Path of the file as given.
    name: str
    # The time of its first sample, by its own clock.
    start_s: float = 0.0
    # Ascending.
    time_s: Floats
    # 0 level, 180 upside down; NaN where the attitude is unknown.
    tilt_deg: Floats
    # Length of the specific force, 1 at rest; NaN where it is unknown or the sensor is implausible.
    specific_force_g: Floats
    # False before the first arming and after the landing: these rows are not judged.
    is_judged: Flags
    # From the first sample of the log to its last, including an end that was lost.
    duration_s: float
    # Share of the samples of attitude or acceleration that were left out as invalid, the larger of the two.
    left_out_share: float = 0.0
    # Above any fixed level; NaN where unknown. None: the log does not say.
    altitude_m: Floats | None = None
    # Where the measuring module lost its state, or another one may have followed.
    resets: "tuple[Marker, ...]" = ()
    # What was left out or looks wrong.
    problems: tuple[UserMessage, ...] = ()

    @property
    def has_plausible_length(self) -> bool:
        return SHORTEST_LOG_S <= self.duration_s <= LONGEST_LOG_S

    @property
    def flights(self) -> Spans:
        """The time that is judged, both ends of the log included; the rest is on the ground."""
        firsts, lasts = runs(self.is_judged)
        begins_s = self.time_s[firsts]
        begins_s[firsts == 0] = 0.0
        ends_s = np.append(self.time_s, self.duration_s)[lasts + 1]
        return np.column_stack((begins_s, ends_s))

    @property
    def tilt_gaps(self) -> Spans:
        """Where in flight no attitude is known for so long that a tilt may be hidden."""
        return self._gaps(self.tilt_deg, TILT_GAP_S)

    @property
    def force_gaps(self) -> Spans:
        """Where in flight no acceleration is known for so long that the module would not go on with a fall."""
        return self._gaps(self.specific_force_g, MAX_GAP_S)

    def _gaps(self, values: Floats, longest_s: float) -> Spans:
        known_s = self.time_s[np.isfinite(values) & self.is_judged]
        bounds_s = np.sort(np.concatenate((known_s, self.flights.ravel())))
        # What follows the end of a flight is on the ground.
        is_gap = (np.diff(bounds_s) > longest_s + GAP_TOLERANCE_S) & ~np.isin(bounds_s[:-1], self.flights[:, 1])
        return np.column_stack((bounds_s[:-1][is_gap], bounds_s[1:][is_gap]))

    @property
    def not_judged_s(self) -> float:
        """Time for which at least one trigger was not judged, whatever the reason, both ends of the log included."""
        if not self.has_plausible_length:
            return round(self.duration_s, 6)
        gaps = np.concatenate((self.tilt_gaps, self.force_gaps))
        begins_s, ends_s = gaps[np.argsort(gaps[:, 0])].T
        # What gaps have in common counts once.
        reached_s = np.maximum.accumulate(np.concatenate(((0.0,), ends_s)))[:-1]
        in_gaps_s = float(np.clip(ends_s - np.maximum(begins_s, reached_s), 0, None).sum())
        return round(self.duration_s - total_s(self.flights) + in_gaps_s, 6)


def total_s(spans: Spans) -> float:
    return float((spans[:, 1] - spans[:, 0]).sum())


def runs(holds: Flags, restarts: Flags | np.bool_ = np.False_) -> tuple[Places, Places]:
    """First and last row of each run of rows in which `holds` is true; a row of `restarts` begins another run."""
    continues = holds & ~restarts
    continues[1:] &= holds[:-1]
    continues[:1] = False
    return np.flatnonzero(holds & ~continues), np.flatnonzero(holds & ~np.append(continues[1:], np.False_))
