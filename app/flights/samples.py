"""Judges whole arrays of samples at once, by the rules of `app.flights.judge.Judge`; `tests/app/flights/test_judge.py`
compares the two sample by sample. Time without reports counts as not judged."""

from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from app.flights.judge import MAX_GAP_S, ROUNDING_S, TriggerLimits
from protocol.messages import Source

MAX_FIRINGS: Final = 500
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Rows = NDArray[np.intp]
"""Indices of samples, ascending."""


class Samples(NamedTuple):
    """Of one quantity, in order of time. What is not active is not judged."""

    time_s: Floats
    values: Floats
    is_active: Flags

    def judged(self, resets_s: Iterable[float]) -> tuple[Floats, Floats, Flags]:
        """Times and values that are judged, and before which of them the module has forgotten everything."""
        restarts = np.diff(self.is_active, prepend=False) & self.is_active
        resets = np.searchsorted(self.time_s, np.fromiter(resets_s, np.float64), "left")
        restarts[resets[resets < len(restarts)]] = True
        return self.time_s[self.is_active], self.values[self.is_active], restarts[self.is_active]


class Firings(NamedTuple):
    """`firings`: when it fires, and why, in order of time, the first `MAX_FIRINGS` of each trigger.

    `longest_miss_s`: of the falls that were too short, from the first to the last report; 0 without any.
    """

    firings: tuple[tuple[float, Source], ...]
    longest_miss_s: float


def judge_samples(
    tilt_deg: Samples, acceleration_g: Samples, limits: TriggerLimits, resets_s: Sequence[float] = ()
) -> Firings:
    """`resets_s`: times at which the module forgot a fall and what had fired (restarts, connections)."""
    sources: dict[float, Source] = {}
    longest_miss_s = 0.0
    if limits.attitude_is_enabled:
        _note(_tilts(*tilt_deg.judged(resets_s), limits), Source.ATTITUDE, sources)
    if limits.freefall_is_enabled:
        falls_s, longest_miss_s = _falls(*acceleration_g.judged(resets_s), limits)
        _note(falls_s, Source.FREEFALL, sources)
    return Firings(tuple((at_s, sources[at_s]) for at_s in sorted(sources)), longest_miss_s)


def _note(fired_s: Floats, source: Source, sources: dict[float, Source]) -> None:
    for at_s in fired_s[:MAX_FIRINGS].tolist():
        sources[at_s] = sources.get(at_s, Source(0)) | source


def _tilts(times: Floats, tilt_deg: Floats, restarts: Flags, limits: TriggerLimits) -> Floats:
    reaches = tilt_deg >= limits.attitude_threshold_deg
    # Between the two angles the trigger stays as it is, unless the module has forgotten it.
    decided = np.flatnonzero(reaches | (tilt_deg <= limits.reset_angle_deg) | restarts)
    is_triggered = reaches[decided]
    fired: Floats = times[decided[is_triggered & (np.diff(is_triggered, prepend=False) | restarts[decided])]]
    return fired


def _falls(times: Floats, weights: Floats, restarts: Flags, limits: TriggerLimits) -> tuple[Floats, float]:
    """When the free-fall trigger fires, and the longest fall that was too short.

    A pause ends a fall; what has fired cannot fire again before the acceleration was at the threshold: falls that
    are only separated by pauses form a block.
    """
    is_below = weights < limits.freefall_acceleration_g
    block_firsts, _ = runs(is_below, restarts)
    firsts, lasts = runs(is_below, restarts | (np.diff(times, prepend=times[:1]) > MAX_GAP_S))
    block = np.searchsorted(block_firsts, firsts, "right") - 1
    since_s = times[firsts]
    lasted_s = times[lasts] - since_s
    long = np.flatnonzero(lasted_s >= limits.freefall_time_s - ROUNDING_S)
    fired_blocks, places = np.unique(block[long], return_index=True)
    fires = long[places]
    places = firing_places(times, limits.freefall_time_s, firsts[fires], since_s[fires])
    return times[places], float(lasted_s[~np.isin(block, fired_blocks)].max(initial=0.0))


def runs(holds: Flags, restarts: Flags | np.bool_ = np.False_) -> tuple[Rows, Rows]:
    """First and last row of each run of rows in which `holds` is true; a row of `restarts` begins another run."""
    continues = holds & ~restarts
    continues[1:] &= holds[:-1]
    continues[:1] = False
    return np.flatnonzero(holds & ~continues), np.flatnonzero(holds & ~np.append(continues[1:], np.False_))


def firing_places(times: Floats, after_s: float | Floats, firsts: Rows, since_s: Floats) -> Rows:
    """The first row of each fall at which the judge fires.

    `after_s`: the free-fall time, one for all or one for each fall.
    """
    places = np.maximum(firsts, np.searchsorted(times, since_s + (after_s - 2 * ROUNDING_S), "left"))
    while (is_early := times[places] - since_s < after_s - ROUNDING_S).any():
        places[is_early] += 1
    return places
