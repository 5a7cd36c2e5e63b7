"""Judges whole arrays of samples at once, by the rules of `app.firing.judge.Judge`; `tests/app/firing/test_judge.py`
compares the two sample by sample. Time without reports counts as not judged."""

from collections.abc import Iterable
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from app.firing.judge import MAX_GAP_S, ROUNDING_S, TriggerLimits
from protocol.messages import Source

MAX_FIRINGS: Final = 500
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Rows = NDArray[np.intp]
"""Indices of samples, ascending."""


class Samples(NamedTuple):
    """Columns in order of time."""

    time_s: Floats
    tilt_deg: Floats
    acceleration_g: Floats
    is_active: Flags

    def where(self, is_kept: Flags) -> "Samples":
        return Samples(
            self.time_s[is_kept], self.tilt_deg[is_kept], self.acceleration_g[is_kept], self.is_active[is_kept]
        )


class Firings(NamedTuple):
    """`firings`: when it fires, and why, in order of time, the first `MAX_FIRINGS`. `longest_miss_s`: of the falls that
    were too short, from the first to the last report; 0 without any."""

    firings: tuple[tuple[float, Source], ...]
    longest_miss_s: float


def judge_samples(samples: Samples, limits: TriggerLimits, resets_s: Iterable[float] = ()) -> Firings:
    """What is not active is not judged. `resets_s`: times at which the module forgot a fall and what had fired
    (restarts, connections)."""
    counts = samples.is_active
    restarts = np.diff(counts, prepend=False) & counts
    resets = np.searchsorted(samples.time_s, np.fromiter(resets_s, np.float64), "left")
    restarts[resets[resets < len(restarts)]] = True
    judged, restarts = samples.where(counts), restarts[counts]
    tilts = falls = _NO_ROWS
    longest_miss_s = 0.0
    if limits.attitude_is_enabled and len(restarts):
        tilts = _tilts(judged, restarts, limits)
    if limits.freefall_is_enabled and len(restarts):
        falls, longest_miss_s = _falls(judged, restarts, limits)
    rows = np.union1d(tilts, falls)[:MAX_FIRINGS]
    is_tilt, is_fall = np.isin(rows, tilts), np.isin(rows, falls)
    causes = [
        (Source.ATTITUDE if tilt else Source(0)) | (Source.FREEFALL if fall else Source(0))
        for tilt, fall in zip(is_tilt, is_fall, strict=True)
    ]
    return Firings(tuple(zip(judged.time_s[rows].tolist(), causes, strict=True)), longest_miss_s)


def _tilts(samples: Samples, restarts: Flags, limits: TriggerLimits) -> Rows:
    """The rows at which the attitude trigger fires."""
    reaches = samples.tilt_deg >= limits.attitude_threshold_deg
    # Between the two angles the trigger stays as it is, unless the module has forgotten it.
    decided = np.flatnonzero(reaches | (samples.tilt_deg <= limits.reset_angle_deg) | restarts)
    is_triggered = reaches[decided]
    fired: Rows = decided[is_triggered & (~np.concatenate(((False,), is_triggered[:-1])) | restarts[decided])]
    return fired


def _falls(samples: Samples, restarts: Flags, limits: TriggerLimits) -> tuple[Rows, float]:
    """The rows at which the free-fall trigger fires, and the longest fall that was too short.

    A pause ends a fall; what has fired cannot fire again before the acceleration was at the threshold: falls that
    are only separated by pauses form a block.
    """
    times, is_below = samples.time_s, samples.acceleration_g < limits.freefall_acceleration_g
    block_firsts, _ = runs(is_below, restarts)
    firsts, lasts = runs(is_below, restarts | (np.diff(times, prepend=times[:1]) > MAX_GAP_S))
    block = np.searchsorted(block_firsts, firsts, "right") - 1
    since_s = times[firsts]
    lasted_s = times[lasts] - since_s
    long = np.flatnonzero(lasted_s >= limits.freefall_time_s - ROUNDING_S)
    fired_blocks, places = np.unique(block[long], return_index=True)
    fires = long[places]
    missed = lasted_s[~np.isin(block, fired_blocks)]
    return (
        firing_places(times, limits.freefall_time_s, firsts[fires], since_s[fires]),
        float(missed.max()) if len(missed) else 0.0,
    )


def runs(holds: Flags, restarts: Flags) -> tuple[Rows, Rows]:
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


_NO_ROWS: Final[Rows] = np.empty(0, np.intp)
