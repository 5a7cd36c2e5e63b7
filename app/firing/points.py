"""Selects the samples at which the state of the judge can change, so that the others can be skipped.

Vectorised, so that hours are judged in a moment. The judge alone decides what happens at these samples;
`tests/app/firing/test_would_fire_skip.py` compares the result with judging every sample.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from app.firing.judge import MAX_GAP_S, ROUNDING_S, Judge, TriggerLimits

Floats = NDArray[np.float64]
Places = NDArray[np.intp]


class Stretch(NamedTuple):
    """One or more samples in order of time; values are the floats nearest to the reported decimals."""

    time_s: Floats
    tilt_deg: Floats
    acceleration_g: Floats

    def part(self, start: int, stop: int) -> "Stretch":
        return Stretch(self.time_s[start:stop], self.tilt_deg[start:stop], self.acceleration_g[start:stop])


class Falls(NamedTuple):
    """Falls of a stretch: indices of the first and the last sample of each, and its start.

    Falls that are only separated by pauses form a block.
    """

    firsts: Places
    lasts: Places
    since_s: Floats
    block: Places
    """Index of each fall's block."""
    block_starts: Places
    block_stops: Places
    """The index after each block; the length of the stretch if the last one may continue."""


def falls_of(stretch: Stretch, limits: TriggerLimits, judge: Judge) -> Falls:
    """`judge`: its state before the first sample; a fall in it may continue here."""
    times = stretch.time_s
    is_below = stretch.acceleration_g < limits.freefall_acceleration_g
    edges = np.flatnonzero(np.diff(is_below, prepend=False, append=False))
    continues = np.zeros(len(times), np.bool_)
    continues[1:] = is_below[1:] & is_below[:-1] & (np.diff(times) <= MAX_GAP_S)
    firsts = np.flatnonzero(is_below & ~continues)
    lasts = np.flatnonzero(is_below & ~np.append(continues[1:], np.False_))
    since_s = times[firsts]
    begun_s, last_s = judge.falls_since_s, judge.last_s
    is_falling = begun_s is not None and last_s is not None and times[0] - last_s <= MAX_GAP_S
    if is_falling and len(firsts) and firsts[0] == 0:
        since_s[0] = begun_s
    starts = edges[::2]
    return Falls(firsts, lasts, since_s, np.searchsorted(starts, firsts, "right") - 1, starts, edges[1::2])


def turning_points(stretch: Stretch, limits: TriggerLimits, falls: Falls | None) -> Places:
    """Sorted indices, the first sample included; `falls` is None if that trigger is off."""
    turns = _attitude_turns(stretch.tilt_deg, limits) if limits.attitude_is_enabled else np.empty(0, np.intp)
    found = [np.zeros(1, np.intp), turns]
    if falls is not None and len(falls.firsts):
        found += _fall_turns(stretch.time_s, limits, falls, turns)
    return np.unique(np.concatenate(found))


def _attitude_turns(tilts: Floats, limits: TriggerLimits) -> Places:
    """Samples that reach the threshold after the reset angle, or the reset angle after the threshold."""
    side = (tilts >= limits.attitude_threshold_deg).astype(np.int8) - (tilts <= limits.reset_angle_deg)
    decided = np.flatnonzero(side)
    turns: Places = decided[np.diff(side[decided], prepend=np.int8(0)) != 0]
    return turns


def _fall_turns(times: Floats, limits: TriggerLimits, falls: Falls, turns: Places) -> list[Places]:
    """Start and end of the falls that may matter, and where they fire; most falls are too short."""
    is_long = times[falls.lasts] - falls.since_s >= limits.freefall_time_s - ROUNDING_S
    matters = np.zeros(len(falls.block_starts), np.bool_)
    matters[falls.block[is_long]] = True
    matters[0] |= falls.block_starts[0] == 0
    matters[-1] |= falls.block_stops[-1] == len(times)
    # If the attitude turns during a fall, the judge must know of the fall.
    around = np.searchsorted(falls.block_starts, turns, "right") - 1
    inside = (around >= 0) & (turns < falls.block_stops[around])
    matters[around[inside]] = True
    stops = falls.block_stops[matters]
    return [
        falls.firsts[matters[falls.block]],
        stops[stops < len(times)],
        firing_places(times, limits.freefall_time_s, falls.firsts[is_long], falls.since_s[is_long]),
    ]


def firing_places(times: Floats, after_s: float | Floats, firsts: Places, since_s: Floats) -> Places:
    """The first sample of each fall at which the judge fires.

    `after_s`: the free-fall time, one for all or one for each fall.
    """
    places = np.maximum(firsts, np.searchsorted(times, since_s + (after_s - 2 * ROUNDING_S), "left"))
    while (is_early := times[places] - since_s < after_s - ROUNDING_S).any():
        places[is_early] += 1
    return places
