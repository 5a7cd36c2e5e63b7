"""Whether a log holds enough to say that nothing would have fired. What is missing is never taken for a calm flight."""

from dataclasses import dataclass
from enum import Enum
from typing import Final

import numpy as np

from app.flights.curves import MAX_ACCELERATION_STEPS, steps_of
from app.flights.flight_log import GAP_TOLERANCE_S, TILT_GAP_S, FlightLog, Floats, Gaps
from app.flights.judge import TriggerLimits
from app.flights.module_view import RuleReading, freefall_view
from app.flights.samples import runs
from app.text.messages import UserMessage, message
from protocol.catalogue import TENTH_G
from protocol.translatable import marked

FALL_MARGIN_S: Final = 0.1
"""A pause in which a fall that is shorter by this than the free-fall time fits may hide one that fires."""
MAX_MISSING_SHARE: Final = 0.1
"""Of the flight, or of the samples, above which its rest proves nothing."""


class Answer(Enum):
    """Would it have fired? The value is its word in JSON."""

    FIRES = "fires"
    DOES_NOT_FIRE = "does_not_fire"
    NOT_JUDGED = "not_judged"
    UNREADABLE = "unreadable"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Coverage:
    """What of one flight is missing, computed once for all thresholds. Time on the ground is not missing."""

    has_plausible_length: bool
    left_out_share: float
    has_tilt_gap: bool
    tilt_missing_share: float
    force_missing_share: float
    hidden_fall_s: Floats
    """Shape (16,): the longest fall that a pause may hide, with the falls around it, by threshold in tenths of g."""

    def is_enough(self, limits: TriggerLimits) -> bool:
        """Whether a flight in which nothing fires with these thresholds may be said not to fire."""
        return self.why_not_enough(limits) is None

    def why_not_enough(self, limits: TriggerLimits) -> UserMessage | None:
        """Why a flight in which nothing fires with these thresholds is not judged."""
        if not self.has_plausible_length:
            return message(marked("No flight has the length of this log."))
        if self.left_out_share > MAX_MISSING_SHARE:
            return message(marked("More than a tenth of the samples was left out."))
        if limits.attitude_is_enabled:
            if self.has_tilt_gap:
                return message(marked("A pause of the attitude of more than 0.2 s may hide a tilt."))
            if self.tilt_missing_share > MAX_MISSING_SHARE:
                return message(marked("More than a tenth of the attitude is missing."))
        if limits.freefall_is_enabled:
            step = steps_of(limits.freefall_acceleration_g, TENTH_G.per_unit)
            longest_s = limits.freefall_time_s - FALL_MARGIN_S + GAP_TOLERANCE_S
            if float(self.hidden_fall_s[step]) > longest_s:
                return message(marked("A pause of the acceleration may hide a fall."))
            if self.force_missing_share > MAX_MISSING_SHARE:
                return message(marked("More than a tenth of the acceleration is missing."))
        return None


def coverage_of(log: FlightLog) -> Coverage:
    ground = log.ground_gaps
    tilt_s = _flight_seconds(log.tilt_gaps, ground)
    force_s = _flight_seconds(log.force_gaps, ground)
    flight_s = log.duration_s - float(np.diff(ground).sum())
    return Coverage(
        has_plausible_length=log.has_plausible_length,
        left_out_share=log.left_out_share,
        has_tilt_gap=bool((tilt_s > TILT_GAP_S + GAP_TOLERANCE_S).any()),
        tilt_missing_share=float(tilt_s.sum()) / flight_s if flight_s > 0 else 1.0,
        force_missing_share=float(force_s.sum()) / flight_s if flight_s > 0 else 1.0,
        hidden_fall_s=_hidden_falls(log, log.force_gaps[force_s > GAP_TOLERANCE_S]),
    )


def _flight_seconds(gaps: Gaps, ground: Gaps) -> Floats:
    """How much of each gap is in flight, and not on the ground; `ground` does not overlap."""
    lasts_s = gaps[:, 1] - gaps[:, 0]
    if not len(ground):
        return lasts_s
    # How long it was on the ground until each bound.
    bounds_s = ground.ravel()
    on_ground_s = np.cumsum(np.diff(bounds_s, prepend=bounds_s[0]) * (np.arange(len(bounds_s)) % 2))
    seconds: Floats = lasts_s - np.diff(np.interp(gaps, bounds_s, on_ground_s))[:, 0]
    return seconds


def _hidden_falls(log: FlightLog, gaps: Gaps) -> Floats:
    """Takes each gap for a fall: the longest fall by threshold in which there is at least one."""
    hidden_s = np.zeros(MAX_ACCELERATION_STEPS + 1)
    if not len(gaps):
        return hidden_s
    known = freefall_view(log, RuleReading.DIRECT)
    steps = np.rint(known.values * TENTH_G.per_unit)
    steps[~known.is_active] = np.inf
    # Each gap becomes two samples without weight, at its begin and at its end. Known samples have the same times: they
    # come before the begin and after the end, so that nothing parts a gap.
    begins_s, ends_s = gaps.T
    time_s = np.concatenate((ends_s, known.time_s, begins_s))
    rank = np.repeat((0, 1, 2), (len(gaps), len(known.time_s), len(gaps)))
    order = np.lexsort((rank, time_s))
    time_s = time_s[order]
    is_gap = rank[order] != 1
    steps = np.where(is_gap, -1.0, np.concatenate((ends_s, steps, begins_s))[order])
    gaps_before = np.concatenate(((0,), np.cumsum(is_gap)))
    for step in range(MAX_ACCELERATION_STEPS + 1):
        firsts, lasts = runs(steps < step)
        has_gap = gaps_before[lasts + 1] > gaps_before[firsts]
        lasted_s = time_s[lasts[has_gap]] - time_s[firsts[has_gap]]
        hidden_s[step] = lasted_s.max(initial=0.0)
    return hidden_s
