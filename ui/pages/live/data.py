"""Data of the Live page: series, limits over time, markers. Times are monotonic seconds."""

from collections import deque
from copy import deepcopy
from typing import Final

import numpy as np

from app.engine.conversation import ConversationView
from app.engine.conversation import StatusSample as Status
from app.engine.worker import Batch
from app.limits.out_of_limits import LimitsInUse
from app.recordings.excerpt import ACTIVE, TRIGGERED, Excerpt, LimitSteps, Measured
from app.recordings.markers import (
    Marker,
    MarkerKind,
    MarkerTracker,
    ModuleLimits,
    acting_limits,
    last_limits,
    limits_of,
)
from app.samples.ring_buffers import Series
from ui.plots.lanes import Lane, Mark, mark_of, measured_lanes

# Ten hours, polled once a second.
_SLOW_SAMPLES: Final = 36_000
_MAX_MARKERS: Final = 1000
_RATE_OVER_S: Final = 2.0


class LiveData(Measured):
    """The data of the current session. Samples are added as arrays: a hundred cost about as much as one."""

    tilt: Series
    acceleration: Series
    cell: Series
    light: Series
    charging: Series
    markers: deque[Marker]

    def __init__(self) -> None:
        super().__init__()
        self.tilt = Series()
        self.acceleration = Series()
        self.cell = Series(_SLOW_SAMPLES)
        self.light = Series(_SLOW_SAMPLES)
        self.charging = Series(_SLOW_SAMPLES)
        self.acting = LimitSteps()
        """The limits that the module acts on, as far as that is known."""
        self.unproven = LimitSteps()
        """What was last known of the others: stale, or of a trigger that is not known to be on."""
        self.markers = deque(maxlen=_MAX_MARKERS)
        # One entry for each sample of tilt and acceleration.
        self._flags = Series()
        self._first_s: float | None = None
        self._tracker = MarkerTracker()

    @property
    def has_samples(self) -> bool:
        """The module has reported a status."""
        return self._first_s is not None

    def reset(self) -> None:
        """Discards everything, for another module."""
        for series in (self.tilt, self.acceleration, self.cell, self.light, self.charging, self._flags):
            series.clear()
        self.clear()
        self.acting.clear()
        self.unproven.clear()
        self.markers.clear()
        self._first_s = None
        self._tracker = MarkerTracker()

    def reports_per_s(self, now_s: float) -> float:
        """Status reports per second, streamed or polled, over the last two seconds."""
        return len(self.tilt.window(now_s - _RATE_OVER_S, now_s).time_s) / _RATE_OVER_S

    def on_batch(self, batch: Batch) -> list[Mark]:
        """Adds a batch; returns its events as marks."""
        count = len(self.markers)
        new = self._tracker.on_batch(batch)
        if batch.samples:
            self._add_samples(batch.samples)
        view = batch.conversation
        self._add_slow(view)
        acting = acting_limits(view, batch.at)
        self.put(batch.at, limits_of(view, batch.at))
        self.acting.put(batch.at, acting)
        self.unproven.put(batch.at, _without(last_limits(view), acting))
        self.markers.extend(new)
        # The first connection is the start of the time line, not an event.
        shown = new[1:] if not count and new and new[0].kind is MarkerKind.CONNECTED else new
        return [mark_of(marker) for marker in shown]

    def excerpt(self, start_s: float, end_s: float) -> Excerpt:
        """A copy of all data in a span, both ends included."""
        flags = self._flags.window(start_s, end_s).value.astype(np.uint8)
        oldest_s = self.tilt.first_s
        is_whole = self._first_s is None or start_s >= oldest_s or self._first_s >= oldest_s
        return deepcopy(self._excerpt(start_s, end_s, flags, is_whole=is_whole))

    def _add_samples(self, samples: tuple[Status, ...]) -> None:
        columns = np.array(samples, np.float64).T
        times = columns[0]
        self.tilt.append(times, columns[1])
        self.acceleration.append(times, columns[2])
        self._flags.append(times, columns[3] * TRIGGERED + columns[4] * ACTIVE)
        if self._first_s is None:
            self._first_s = float(times[0])

    def _add_slow(self, device: ConversationView) -> None:
        for series, key in ((self.cell, "cell_voltage_v"), (self.light, "light_v"), (self.charging, "charging")):
            known = device.values.get(key)
            if known is None or known.is_stale:
                continue
            last = series.last
            if last is None and device.ended is not None:
                continue  # it was read before these curves began
            if last is None or known.at > last.time_s:
                series.append(known.at, float(known.value))


def _without(known: ModuleLimits, acting: ModuleLimits) -> ModuleLimits:
    return ModuleLimits(*(old if new is None else None for old, new in zip(known, acting, strict=True)))


def live_lanes(data: LiveData, in_use: LimitsInUse) -> tuple[Lane, ...]:
    return measured_lanes(data, in_use, data.acting, data.unproven)
