"""What-if analysis: would these settings have fired on measured data? With near misses and margins.

Whole arrays are judged at once, by the rules of `app.firing.judge.Judge`; `tests/app/firing/test_judge.py`
compares the two sample by sample. Time without reports counts as not judged.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from app.firing.judge import MAX_GAP_S, ROUNDING_S, Firing, SensorSample, TriggerLimits
from app.recordings.excerpt import Excerpt
from app.recordings.markers import STATE_LOST
from app.samples.ring_buffers import Values
from protocol.messages import Source

MAX_FIRINGS: Final = 500
MAX_NEAR_MISSES: Final = 50
"""Listed of each trigger."""
REPORT_STEP_DEG: Final = 1.0
"""Reports have whole degrees: an angle nearer than this may have reached the threshold."""
_DECIMALS: Final = 3
"""Undoes the rounding to 32-bit floats: the float nearest to 0.7 becomes 0.7 again."""

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Rows = NDArray[np.intp]
"""Indices of samples, ascending."""


class Samples(NamedTuple):
    """Columns in order of time."""

    time_s: Floats
    tilt_deg: Floats | Values
    acceleration_g: Floats | Values
    is_active: Flags

    def where(self, is_kept: Flags) -> "Samples":
        return Samples(
            self.time_s[is_kept], self.tilt_deg[is_kept], self.acceleration_g[is_kept], self.is_active[is_kept]
        )


class NearTilt(NamedTuple):
    """The highest angle between two returns to the reset angle, if below the threshold."""

    at_s: float
    tilt_deg: float
    margin_deg: float
    """To the threshold, above 0."""

    @property
    def may_have_fired(self) -> bool:
        """Nearer than the resolution of the reports."""
        return self.margin_deg <= REPORT_STEP_DEG


class NearFall(NamedTuple):
    """A fall shorter than the free-fall time."""

    since_s: float
    lasted_s: float
    """From its first to its last report."""
    margin_s: float
    """Missing to the free-fall time."""
    lowest_g: float
    longest_s: float
    """Upper bound of its duration: from the report before it to the one after; infinity without either."""

    @property
    def ended_s(self) -> float:
        return self.since_s + self.lasted_s

    @property
    def may_have_fired(self) -> bool:
        """Whether it may have lasted as long as the free-fall time."""
        return self.longest_s >= self.lasted_s + self.margin_s


class Lowest(NamedTuple):
    """The lowest acceleration that was reported."""

    at_s: float
    acceleration_g: float


@dataclass(frozen=True, slots=True)
class Pauses:
    """Time between reports that are too far apart."""

    count: int = 0
    total_s: float = 0.0
    longest_s: float = 0.0
    longest_at_s: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class WhatIfFinding:
    """Times are those of the samples."""

    limits: TriggerLimits
    counts_locked: bool
    """Reports of a locked module were judged as those of an active one."""
    report_count: int
    """Of the judged reports."""
    first_s: float | None
    judged_s: float
    """Time covered by the reports."""
    locked_s: float
    """Time that the module was locked; `counts_locked` tells whether it was judged."""
    pauses: Pauses
    is_whole: bool
    """False if only lowest and highest values are left of the time before `first_s`."""
    firings: tuple[Firing, ...]
    """The first `MAX_FIRINGS`, oldest first."""
    firing_count: int
    near_tilts: tuple[NearTilt, ...]
    """The nearest first."""
    near_falls: tuple[NearFall, ...]
    """The longest first."""
    nearest_tilt: NearTilt | None
    """Includes angles below the reset angle; None if the trigger is off, or no angle is below the threshold."""
    lowest: Lowest | None
    """None if the trigger is off."""

    @property
    def is_judged(self) -> bool:
        """Whether any time could be judged."""
        return self.judged_s > 0

    @property
    def longest_fall(self) -> NearFall | None:
        return self.near_falls[0] if self.near_falls else None


def judge_excerpt(excerpt: Excerpt, limits: TriggerLimits, *, counts_locked: bool) -> WhatIfFinding:
    """Judge all samples of an excerpt; takes about 30 ms for a million."""
    return judge_samples(
        Samples(*excerpt.tilt, excerpt.acceleration.value, excerpt.is_active), limits,
        resets_s=[marker.time_s for marker in excerpt.markers if marker.kind in STATE_LOST],
        counts_locked=counts_locked, is_whole=excerpt.is_whole,
    )  # fmt: skip


def judge_samples(
    samples: Samples, limits: TriggerLimits, *, resets_s: Iterable[float] = (), counts_locked: bool,
    is_whole: bool = True,
) -> WhatIfFinding:  # fmt: skip
    """`resets_s`: times at which the module forgot a fall and what had fired (restarts, connections)."""
    counts = samples.is_active | counts_locked
    restarts = np.diff(counts, prepend=False) & counts
    resets = np.searchsorted(samples.time_s, np.fromiter(resets_s, np.float64), "left")
    restarts[resets[resets < len(restarts)]] = True
    judged = samples
    if not counts.all():
        judged, restarts = samples.where(counts), restarts[counts]
    tilts = _Tilts(judged, restarts, limits) if limits.attitude_is_enabled and len(restarts) else None
    falls = _Falls(judged, restarts, limits) if limits.freefall_is_enabled and len(restarts) else None
    fired = np.union1d(_NO_ROWS if tilts is None else tilts.fired, _NO_ROWS if falls is None else falls.fired)
    judged_s, locked_s, pauses = _times(samples, counts)
    return WhatIfFinding(
        limits=limits,
        counts_locked=counts_locked,
        report_count=len(restarts),
        first_s=float(samples.time_s[0]) if len(counts) else None,
        judged_s=judged_s,
        locked_s=locked_s,
        pauses=pauses,
        is_whole=is_whole,
        firings=tuple(_firing(judged, row, tilts, falls) for row in fired[:MAX_FIRINGS].tolist()),
        firing_count=len(fired),
        near_tilts=() if tilts is None else tilts.near,
        near_falls=() if falls is None else falls.near,
        nearest_tilt=None if tilts is None else tilts.nearest,
        lowest=None if falls is None else falls.lowest,
    )


class _Tilts:
    """What the attitude trigger does: `fired` rows, near misses."""

    def __init__(self, samples: Samples, restarts: Flags, limits: TriggerLimits) -> None:
        self._samples, self._threshold_deg = samples, limits.attitude_threshold_deg
        tilts = samples.tilt_deg
        threshold, reset = tilts.dtype.type(limits.attitude_threshold_deg), tilts.dtype.type(limits.reset_angle_deg)
        is_above = tilts > reset
        reaches = tilts >= threshold
        # Between the two angles the trigger stays as it is, unless the module has forgotten it.
        decided = np.flatnonzero(reaches | ~is_above | restarts)
        is_triggered = reaches[decided]
        self.fired: Rows = decided[is_triggered & (~np.concatenate(((False,), is_triggered[:-1])) | restarts[decided])]
        firsts, lasts = runs(is_above, restarts)
        peaks = np.maximum.reduceat(tilts, firsts) if len(firsts) else tilts[:0]  # between runs it is lower
        missed = np.flatnonzero(peaks < threshold)
        best = missed[np.argsort(-peaks[missed], kind="stable")[:MAX_NEAR_MISSES]]
        self.near = tuple(
            self._near(first + int(np.argmax(tilts[first : last + 1])))
            for first, last in zip(firsts[best].tolist(), lasts[best].tolist(), strict=True)
        )
        self.nearest = next(iter(self.near), None)
        if self.nearest is None and not is_above.all():
            self.nearest = self._near(int(np.argmax(np.where(is_above, -np.inf, tilts))))

    def _near(self, row: int) -> NearTilt:
        tilt_deg = _exact(self._samples.tilt_deg[row])
        return NearTilt(float(self._samples.time_s[row]), tilt_deg, self._threshold_deg - tilt_deg)


class _Falls:
    """What the free-fall trigger does: `fired` rows, near misses.

    A pause ends a fall; what has fired cannot fire again before the acceleration was at the threshold: falls that
    are only separated by pauses form a block.
    """

    def __init__(self, samples: Samples, restarts: Flags, limits: TriggerLimits) -> None:
        times, weights = samples.time_s, samples.acceleration_g
        is_below = weights < weights.dtype.type(limits.freefall_acceleration_g)
        block_firsts, _ = runs(is_below, restarts)
        firsts, lasts = runs(is_below, restarts | (np.diff(times, prepend=times[:1]) > MAX_GAP_S))
        block = np.searchsorted(block_firsts, firsts, "right") - 1
        since_s = times[firsts]
        lasted_s = times[lasts] - since_s
        long = np.flatnonzero(lasted_s >= limits.freefall_time_s - ROUNDING_S)
        fired_blocks, places = np.unique(block[long], return_index=True)
        fires = long[places]
        self.fired = firing_places(times, limits.freefall_time_s, firsts[fires], since_s[fires])
        missed = np.flatnonzero(~np.isin(block, fired_blocks))
        best = missed[np.argsort(-lasted_s[missed], kind="stable")[:MAX_NEAR_MISSES]]
        lowest = np.minimum.reduceat(weights, firsts) if len(firsts) else weights  # between falls it is higher
        is_end = np.append(restarts[1:], np.True_)
        self.near = tuple(
            NearFall(
                float(since_s[fall]),
                float(lasted_s[fall]),
                limits.freefall_time_s - float(lasted_s[fall]),
                _exact(lowest[fall]),
                (np.inf if is_end[last] else float(times[last + 1]))
                - (-np.inf if restarts[first] else float(times[first - 1])),
            )
            for fall, first, last in zip(best.tolist(), firsts[best].tolist(), lasts[best].tolist(), strict=True)
        )
        row = int(np.argmin(weights))
        self.lowest = Lowest(float(times[row]), _exact(weights[row]))


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


def _firing(samples: Samples, row: int, tilts: _Tilts | None, falls: _Falls | None) -> Firing:
    sources = Source(0)
    for source, judged in ((Source.ATTITUDE, tilts), (Source.FREEFALL, falls)):
        if judged is not None and row in judged.fired:
            sources |= source
    tilt_deg, acceleration_g = _exact(samples.tilt_deg[row]), _exact(samples.acceleration_g[row])
    return Firing(SensorSample(float(samples.time_s[row]), tilt_deg, acceleration_g), sources)


def _times(samples: Samples, counts: Flags) -> tuple[float, float, Pauses]:
    """Time that was judged, time locked, and pauses; between two reports the module is as in the first of them."""
    steps = np.diff(samples.time_s)
    is_pause = steps > MAX_GAP_S
    judged_s = float(steps[~is_pause & counts[:-1]].sum())
    locked_s = float(steps[~is_pause & ~samples.is_active[:-1]].sum())
    if not is_pause.any():
        return judged_s, locked_s, Pauses()
    longest = int(np.argmax(steps))
    pauses = Pauses(
        int(is_pause.sum()), float(steps[is_pause].sum()), float(steps[longest]), float(samples.time_s[longest])
    )
    return judged_s, locked_s, pauses


def _exact(value: np.floating) -> float:
    return round(float(value), _DECIMALS)


_NO_ROWS: Final[Rows] = np.empty(0, np.intp)
