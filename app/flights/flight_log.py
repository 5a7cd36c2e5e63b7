"""A flight as a module on the aircraft would have measured it, independent of the format of the log.

Times are seconds since the first sample, angles degrees, accelerations multiples of g.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from app.flights.samples import runs
from app.text.messages import UserMessage, message
from app.text.user_error import UserError
from protocol.translatable import marked

if TYPE_CHECKING:
    from app.recordings.markers import Marker

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Gaps = NDArray[np.float64]
"""Shape (number, 2): begin and end of each, in seconds; ascending."""
Progress = Callable[[float], object]
"""Called with the share of a long file that is read; may raise, to end reading."""
NO_PROGRESS: Final[Progress] = bool
NO_GAPS: Final[Gaps] = np.empty((0, 2))

REPORT_HZ: Final = 50
"""Rows per second of a `FlightLog` that no module measured; the rate of the simulated module."""
TILT_GAP_S: Final = 0.2
"""The shortest tilt that fires under either reading of the rule. A longer pause between two attitudes may hide one."""
GAP_TOLERANCE_S: Final = 0.01
"""Half a report: clocks of logs jitter."""
SHORTEST_LOG_S: Final = 1.0
LONGEST_LOG_S: Final = 24 * 3600.0
"""No flight is shorter or longer: where a log is, its clock or the unit of its times is wrong."""


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
    """From the first sample of the log to its last, including an end that was lost."""
    tilt_gaps: Gaps = field(default_factory=NO_GAPS.copy)
    """Where no attitude is known for so long that a tilt may be hidden, at both ends of the log, too."""
    force_gaps: Gaps = field(default_factory=NO_GAPS.copy)
    """Where no acceleration is known, or none that is believed."""
    left_out_share: float = 0.0
    """Share of the samples of attitude or acceleration that were left out as invalid, the larger of the two."""
    disarmed_gaps: Gaps = field(default_factory=NO_GAPS.copy)
    """Pauses that began while the flight controller was disarmed, as where it logs flights only."""
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
    def has_plausible_length(self) -> bool:
        return SHORTEST_LOG_S <= self.duration_s <= LONGEST_LOG_S

    @property
    def ground_gaps(self) -> Gaps:
        """Where the log says that the aircraft was not in flight."""
        firsts, lasts = runs(~self.is_judged)
        begins = self.time_s[firsts]
        begins[firsts == 0] = 0.0
        ends = np.append(self.time_s, self.duration_s)[lasts + 1]
        return merged(np.concatenate((np.column_stack((begins, ends)), self.disarmed_gaps)))

    @property
    def not_judged_s(self) -> float:
        """Time for which at least one trigger was not judged, whatever the reason, both ends of the log included."""
        if not self.has_plausible_length:
            return round(self.duration_s, 6)
        gaps = merged(np.concatenate((self.tilt_gaps, self.force_gaps, self.ground_gaps)))
        return round(float(np.diff(gaps).sum()), 6)


def gaps_between(time_s: Floats, start_s: float, end_s: float, longest_s: float) -> Gaps:
    """The pauses between samples, and between them and both ends of the log, that are longer than `longest_s`."""
    bounds = np.concatenate(((start_s,), time_s, (end_s,)))
    is_gap = np.diff(bounds) > longest_s + GAP_TOLERANCE_S
    return np.column_stack((bounds[:-1][is_gap], bounds[1:][is_gap]))


def merged(gaps: Gaps) -> Gaps:
    """The same time in gaps that do not overlap."""
    if not len(gaps):
        return gaps
    order = np.argsort(gaps[:, 0], kind="stable")
    begins, ends = gaps[order].T
    reached = np.maximum.accumulate(ends)
    is_first = np.append(np.True_, begins[1:] > reached[:-1])
    lasts = np.append(np.flatnonzero(is_first)[1:] - 1, len(begins) - 1)
    return np.column_stack((begins[is_first], reached[lasts]))
