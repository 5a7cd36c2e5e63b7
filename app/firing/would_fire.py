"""What-if analysis: would these settings have fired on measured data? With near misses and margins.

`app.firing.judge.Judge` decides, as in the simulated module. Time without reports, or of which only the lowest and
highest values are left, counts as not judged.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.firing.judge import MAX_GAP_S, Firing, Judge, SensorSample, TriggerLimits
from app.firing.near_misses import Lowest, NearFall, NearFalls, NearTilt, NearTilts
from app.firing.points import Stretch, falls_of, turning_points
from app.recordings.excerpt import Excerpt
from app.recordings.markers import STATE_LOST
from app.samples.ring_buffers import Seconds, Values

MAX_FIRINGS: Final = 500
_DECIMALS: Final = 3
"""Undoes the rounding to 32-bit floats: 0.7 g becomes the float nearest to 0.7 again."""


@dataclass(frozen=True, slots=True)
class Pauses:
    """Time between reports that are too far apart."""

    count: int = 0
    total_s: float = 0.0
    longest_s: float = 0.0
    longest_at_s: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class WhatIfFinding:
    """The result so far. Times are monotonic seconds."""

    limits: TriggerLimits
    counts_locked: bool
    """Reports of a locked module were judged as those of an active one."""
    report_count: int
    """Of the judged reports."""
    first_s: float | None
    last_s: float | None
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
    """Includes angles below the reset angle; None if the trigger is off, or every approach fired."""
    lowest: Lowest | None
    """None if the trigger is off."""

    @property
    def is_judged(self) -> bool:
        """Whether any time could be judged."""
        return self.judged_s > 0

    @property
    def longest_fall(self) -> NearFall | None:
        return self.near_falls[0] if self.near_falls else None


class WhatIfAnalysis:
    """Judges reports in order, any number at a time; `finding` is the result so far."""

    def __init__(self, limits: TriggerLimits, *, counts_locked: bool = True) -> None:
        self.limits = limits
        self.counts_locked = counts_locked
        self._judge = Judge()
        self._firings: list[Firing] = []
        self._firing_count = 0
        self._tilts = NearTilts(limits)
        self._falls = NearFalls(limits)
        self._lowest: Lowest | None = None
        self._report_count = 0
        self._first_s: float | None = None
        self._last_s: float | None = None
        self._was_active = False
        self._judged_s = self._locked_s = 0.0
        self._pauses = Pauses()
        self._is_whole = True

    @property
    def last_s(self) -> float | None:
        """Time of the last report."""
        return self._last_s

    @property
    def finding(self) -> WhatIfFinding:
        limits = self.limits
        return WhatIfFinding(
            limits=limits,
            counts_locked=self.counts_locked,
            report_count=self._report_count,
            first_s=self._first_s,
            last_s=self._last_s,
            judged_s=self._judged_s,
            locked_s=self._locked_s,
            pauses=self._pauses,
            is_whole=self._is_whole,
            firings=tuple(self._firings),
            firing_count=self._firing_count,
            near_tilts=self._tilts.found if limits.attitude_is_enabled else (),
            near_falls=self._falls.found if limits.freefall_is_enabled else (),
            nearest_tilt=self._tilts.nearest if limits.attitude_is_enabled else None,
            lowest=self._lowest if limits.freefall_is_enabled else None,
        )

    def feed(self, excerpt: Excerpt, *, start: int = 0, stop: int | None = None) -> None:
        """Judge the reports `start` to `stop` (exclusive)."""
        rows = slice(start, stop)
        stretch = Stretch(
            np.asarray(excerpt.time_s[rows], np.float64),
            _exact(excerpt.tilt_deg[rows]),
            _exact(excerpt.acceleration_g[rows]),
        )
        times, is_active = stretch.time_s, np.asarray(excerpt.is_active[rows])
        if not len(times):
            return
        if self._first_s is None:
            self._first_s = float(times[0])
            self._is_whole = excerpt.is_whole
        cuts = set(np.searchsorted(times, self._state_losses(excerpt, float(times[-1])), "left").tolist())
        counts = is_active | self.counts_locked
        edges = np.flatnonzero(np.diff(counts)) + 1
        bounds = sorted({0, *edges.tolist(), *cuts} - {len(times)})
        for first, after in zip(bounds, [*bounds[1:], len(times)], strict=True):
            if first in cuts or not counts[first]:
                self._reset_state()
            if counts[first]:
                self._judge_part(stretch.part(first, after))
        self._count_time(times, is_active)

    def _state_losses(self, excerpt: Excerpt, last_s: float) -> list[float]:
        since_s = -np.inf if self._last_s is None else self._last_s
        return [one.time_s for one in excerpt.markers
                if one.kind in STATE_LOST and since_s < one.time_s <= last_s]  # fmt: skip

    def _reset_state(self) -> None:
        self._judge.reset()
        self._tilts.interrupt()
        self._falls.reset_time()

    def _judge_part(self, stretch: Stretch) -> None:
        limits, judge = self.limits, self._judge
        falls = falls_of(stretch, limits, judge) if limits.freefall_is_enabled else None
        if falls is not None:
            self._falls.add(stretch, falls)
            self._note_lowest(stretch)
        if limits.attitude_is_enabled:
            self._tilts.add(stretch)
        places = turning_points(stretch, limits, falls)
        before = -1
        rows = zip(places.tolist(), *(column[places].tolist() for column in stretch), strict=True)
        for place, at_s, tilt_deg, acceleration_g in rows:
            if place - before > 1:
                judge.skip_to(float(stretch.time_s[place - 1]))
            sample = SensorSample(at_s, tilt_deg, acceleration_g)
            if fired := judge.judge(sample, limits).fired:
                self._firing_count += 1
                if len(self._firings) < MAX_FIRINGS:
                    self._firings.append(Firing(sample, fired))
            before = place
        judge.skip_to(float(stretch.time_s[-1]))
        self._report_count += len(stretch.time_s)

    def _note_lowest(self, stretch: Stretch) -> None:
        place = int(np.argmin(stretch.acceleration_g))
        lowest = Lowest(float(stretch.time_s[place]), float(stretch.acceleration_g[place]))
        if self._lowest is None or lowest.acceleration_g < self._lowest.acceleration_g:
            self._lowest = lowest

    def _count_time(self, times: Seconds, is_active: NDArray[np.bool_]) -> None:
        """The time between two reports counts as locked or active as in the first of them."""
        if self._last_s is not None:
            times = np.concatenate(((self._last_s,), times))
            is_active = np.concatenate(((self._was_active,), is_active))
        steps = np.diff(times)
        is_pause = steps > MAX_GAP_S
        is_locked = ~is_active[:-1]
        counts = ~is_pause if self.counts_locked else ~is_pause & ~is_locked
        self._judged_s += float(steps[counts].sum())
        self._locked_s += float(steps[is_locked & ~is_pause].sum())
        if is_pause.any():
            longest = int(np.argmax(steps))
            was, is_longer = self._pauses, steps[longest] > self._pauses.longest_s
            self._pauses = Pauses(
                was.count + int(is_pause.sum()),
                was.total_s + float(steps[is_pause].sum()),
                float(steps[longest]) if is_longer else was.longest_s,
                float(times[longest]) if is_longer else was.longest_at_s,
            )
        self._last_s, self._was_active = float(times[-1]), bool(is_active[-1])


def _exact(values: Values) -> NDArray[np.float64]:
    return values.astype(np.float64).round(_DECIMALS)
