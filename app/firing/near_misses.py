"""Finds near misses: angles close to the threshold, falls that were too short.

The result does not depend on how the samples are divided into stretches. Only the nearest are kept.
"""

import math
from typing import Final, NamedTuple

import numpy as np

from app.firing.judge import ROUNDING_S, TriggerLimits
from app.firing.points import Falls, Floats, Places, Stretch

MAX_FOUND: Final = 50
REPORT_STEP_DEG: Final = 1.0
"""Reports have whole degrees: an angle nearer than this may have reached the threshold."""


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
    """Upper bound of its duration: from the report before it to the one after; infinity without a report after."""

    @property
    def may_have_fired(self) -> bool:
        """Whether it may have lasted as long as the free-fall time."""
        return self.longest_s >= self.lasted_s + self.margin_s


class Lowest(NamedTuple):
    """The lowest acceleration that was reported."""

    at_s: float
    acceleration_g: float


class NearTilts:
    """Near misses of the attitude trigger, stretch by stretch."""

    def __init__(self, limits: TriggerLimits) -> None:
        self._threshold_deg = limits.attitude_threshold_deg
        self._reset_deg = limits.reset_angle_deg
        self._found: list[NearTilt] = []
        self._open: NearTilt | None = None
        """The peak of an approach that is not over; its margin is 0 or less if it fired."""
        self._calm: NearTilt | None = None
        """The highest angle at or below the reset angle."""

    @property
    def found(self) -> tuple[NearTilt, ...]:
        """Approaches above the reset angle, the nearest first."""
        return tuple(_nearest_tilts([*self._found, *self._unfired_open()]))

    @property
    def nearest(self) -> NearTilt | None:
        """The nearest of all, also below the reset angle; None if every approach fired."""
        return next(iter(self.found), self._calm)

    def add(self, stretch: Stretch) -> None:
        tilts = stretch.tilt_deg
        is_above = tilts > self._reset_deg
        if not is_above.all():
            self._note_calm(stretch, int(np.argmax(np.where(is_above, -math.inf, tilts))))
        edges = np.flatnonzero(np.diff(is_above, prepend=False, append=False))
        starts, stops = edges[::2], edges[1::2]
        if self._open is not None and not is_above[0]:
            self.interrupt()
        if not len(starts):
            return
        peaks = np.maximum.reduceat(tilts, edges[edges < len(tilts)])[::2]
        goes_on = stops[-1] == len(tilts)
        first = 0
        if self._open is not None:
            peak = self._peak(stretch, int(starts[0]), int(stops[0]))
            self._open = max(self._open, peak, key=lambda one: one.tilt_deg)
            if goes_on and len(starts) == 1:
                return
            self.interrupt()
            first = 1
        last = len(starts) - 1 if goes_on else len(starts)
        near = first + np.flatnonzero(peaks[first:last] < self._threshold_deg)
        best = near[np.argsort(-peaks[near], kind="stable")[:MAX_FOUND]]
        self._add_nearest([self._peak(stretch, int(starts[one]), int(stops[one])) for one in best])
        if goes_on:
            self._open = self._peak(stretch, int(starts[-1]), int(stops[-1]))

    def interrupt(self) -> None:
        """What follows is unrelated: the module was locked, restarted, or back below the reset angle."""
        self._add_nearest(self._unfired_open())
        self._open = None

    def _note_calm(self, stretch: Stretch, place: int) -> None:
        calm = self._near(stretch, place)
        if self._calm is None or calm.tilt_deg > self._calm.tilt_deg:
            self._calm = calm

    def _peak(self, stretch: Stretch, start: int, stop: int) -> NearTilt:
        return self._near(stretch, start + int(np.argmax(stretch.tilt_deg[start:stop])))

    def _near(self, stretch: Stretch, place: int) -> NearTilt:
        tilt_deg = float(stretch.tilt_deg[place])
        return NearTilt(float(stretch.time_s[place]), tilt_deg, self._threshold_deg - tilt_deg)

    def _unfired_open(self) -> list[NearTilt]:
        return [] if self._open is None or self._open.margin_deg <= 0 else [self._open]

    def _add_nearest(self, near: list[NearTilt]) -> None:
        if near:
            self._found = _nearest_tilts([*self._found, *near])


class NearFalls:
    """Near misses of the free-fall trigger, stretch by stretch."""

    def __init__(self, limits: TriggerLimits) -> None:
        self._after_s = limits.freefall_time_s
        self._found: list[NearFall] = []
        self._open: NearFall | None = None
        """A fall that may continue with the next sample."""
        self._before_open_s = -math.inf
        self._pending: list[NearFall] = []
        """Earlier falls of the block that may continue: near misses only if the block does not fire."""
        self._has_fired = False
        """Whether the block that may continue has fired."""
        self._last_s = -math.inf

    @property
    def found(self) -> tuple[NearFall, ...]:
        """The longest first."""
        return tuple(_nearest_falls([*self._found, *self._unfired()]))

    def add(self, stretch: Stretch, falls: Falls) -> None:
        times = stretch.time_s
        is_falling = bool(len(falls.firsts)) and falls.firsts[0] == 0
        opened = self._open
        if opened is not None and not (is_falling and falls.since_s[0] == opened.since_s):
            self._pending.append(opened._replace(longest_s=float(times[0]) - self._before_open_s))
            self._open = None
        goes_on = opened is not None and is_falling
        if not goes_on:
            self.interrupt()
        if len(falls.firsts):
            self._add_falls(_measured(stretch, falls, self._last_s), falls, goes_on=goes_on)
        self._last_s = float(times[-1])

    def interrupt(self) -> None:
        """What follows is unrelated: the module was locked or restarted, or the fall was over."""
        self._add_nearest(self._unfired())
        self._open, self._pending, self._has_fired = None, [], False

    def reset_time(self) -> None:
        """Like `interrupt`; the time of the report before the next one is unknown, too."""
        self.interrupt()
        self._last_s = -math.inf

    def _add_falls(self, found: "_Measured", falls: Falls, *, goes_on: bool) -> None:
        if self._open is not None:
            found.lowest_g[0] = min(found.lowest_g[0], self._open.lowest_g)
            found.before_s[0] = self._before_open_s
        has_fired = np.zeros(len(falls.block_starts), np.bool_)
        has_fired[falls.block[found.lasted_s >= self._after_s - ROUNDING_S]] = True
        has_fired[0] |= goes_on and self._has_fired
        is_open = bool(np.isinf(found.after_s[-1]))
        last_block = len(has_fired) - 1
        is_last = (falls.block == last_block) & is_open
        self._add_nearest(self._near(found, np.flatnonzero(~has_fired[falls.block] & ~is_last)))
        is_one_block = is_open and last_block == 0
        if not is_one_block:
            if not has_fired[0]:
                self._add_nearest(self._pending)
            self._pending = []
        self._open, self._has_fired = None, False
        if is_open:
            self._pending = _nearest_falls([*self._pending, *self._near(found, np.flatnonzero(is_last)[:-1])])
            self._open = self._near(found, np.array([len(found.lasted_s) - 1]))[0]
            self._before_open_s = float(found.before_s[-1])
            self._has_fired = bool(has_fired[-1])

    def _near(self, found: "_Measured", which: Places) -> list[NearFall]:
        """The longest of them."""
        best = which[np.argsort(-found.lasted_s[which], kind="stable")[:MAX_FOUND]]
        return [
            NearFall(since_s, lasted_s, self._after_s - lasted_s, lowest_g, after_s - before_s)
            for since_s, lasted_s, lowest_g, before_s, after_s in zip(
                *(column[best].tolist() for column in found), strict=True
            )
        ]

    def _unfired(self) -> list[NearFall]:
        """Falls of the block that may continue, unless it fired."""
        if self._has_fired:
            return []
        return self._pending if self._open is None else [*self._pending, self._open]

    def _add_nearest(self, near: list[NearFall]) -> None:
        if near:
            self._found = _nearest_falls([*self._found, *near])


class _Measured(NamedTuple):
    """Falls of a stretch as columns; `before_s` and `after_s`: times of the reports around each."""

    since_s: Floats
    lasted_s: Floats
    lowest_g: Floats
    before_s: Floats
    after_s: Floats


def _measured(stretch: Stretch, falls: Falls, last_s: float) -> _Measured:
    """`last_s`: time of the report before the stretch."""
    times = stretch.time_s
    ends = np.column_stack((falls.firsts, falls.lasts + 1)).ravel()
    weights = np.append(stretch.acceleration_g, math.inf)  # so that the last end is a place too
    return _Measured(
        falls.since_s,
        times[falls.lasts] - falls.since_s,
        np.minimum.reduceat(weights, ends)[::2],
        np.concatenate(((last_s,), times))[falls.firsts],
        np.append(times, math.inf)[falls.lasts + 1],
    )


def _nearest_tilts(near: list[NearTilt]) -> list[NearTilt]:
    return sorted(near, key=lambda one: (one.margin_deg, one.at_s))[:MAX_FOUND]


def _nearest_falls(near: list[NearFall]) -> list[NearFall]:
    return sorted(near, key=lambda one: (one.margin_s, one.since_s))[:MAX_FOUND]
