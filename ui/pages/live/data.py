"""Data of the Live page: series, limits over time, markers. Times are monotonic seconds."""

from collections import deque
from copy import deepcopy
from typing import Final

import numpy as np

from app.engine.worker import Batch
from app.recordings.excerpt import ACTIVE, TRIGGERED, Excerpt, LimitSteps, Measured
from app.recordings.markers import Marker, MarkerKind, MarkerTracker, ModuleLimits, acting_limits, last_limits
from app.samples.samples import Series
from ui.plots.lanes import Mark, mark_of

# Ten hours, polled once a second.
_SLOW_SAMPLES: Final = 36_000
_MAX_MARKERS: Final = 1000


class LiveData(Measured):
    """The data of the current session. Samples are added as arrays: a hundred cost about as much as one."""

    tilt: Series
    acceleration: Series
    cell: Series
    light: Series
    charging: Series
    flags: Series
    markers: deque[Marker]

    def __init__(self) -> None:
        super().__init__()
        self.tilt, self.acceleration, self.flags = Series(), Series(), Series()
        self.cell, self.light, self.charging = (Series(_SLOW_SAMPLES) for _ in range(3))
        # The limits that the module acts on, and what was last known of the others: stale, or of a trigger that is not
        # known to be on.
        self.acting, self.unproven = LimitSteps(), LimitSteps()
        self.markers = deque(maxlen=_MAX_MARKERS)
        self._first_s: float | None = None
        self._tracker = MarkerTracker()

    @property
    def has_samples(self) -> bool:
        return self._first_s is not None

    def reset(self) -> None:
        for series in (self.tilt, self.acceleration, self.cell, self.light, self.charging, self.flags):
            series.clear()
        self.acting.clear()
        self.unproven.clear()
        self.markers.clear()
        self._first_s = None
        self._tracker = MarkerTracker()

    def on_batch(self, batch: Batch) -> list[Mark]:
        """Adds a batch; returns its events as marks."""
        if batch.samples:
            times, tilt, acceleration, triggered, active = np.array(batch.samples, np.float64).T
            self.tilt.append(times, tilt)
            self.acceleration.append(times, acceleration)
            self.flags.append(times, triggered * TRIGGERED + active * ACTIVE)
            if self._first_s is None:
                self._first_s = float(times[0])
        view = batch.conversation
        for series, key in ((self.cell, "cell_voltage_v"), (self.light, "light_v"), (self.charging, "charging")):
            known, last = view.values.get(key), series.last
            if known is None or known.is_stale or (last is not None and known.at <= last.time_s):
                continue
            if last is not None or view.ended is None:  # else it was read before these curves began
                series.append(known.at, float(known.value))
        acting = acting_limits(view, batch.at)
        self.acting.put(batch.at, acting)
        others = (old if new is None else None for old, new in zip(last_limits(view), acting, strict=True))
        self.unproven.put(batch.at, ModuleLimits(*others))
        is_first = not self.markers
        new = self._tracker.on_batch(batch)
        self.markers.extend(new)
        # The first connection is the start of the time line, not an event.
        shown = new[1:] if is_first and new and new[0].kind is MarkerKind.CONNECTED else new
        return [mark_of(marker) for marker in shown]

    def excerpt(self, start_s: float, end_s: float) -> Excerpt:
        """A copy of all data in a span, both ends included."""
        oldest_s = self.tilt.first_s
        is_whole = self._first_s is None or start_s >= oldest_s or self._first_s >= oldest_s
        return deepcopy(super().excerpt(start_s, end_s)._replace(is_whole=is_whole))
