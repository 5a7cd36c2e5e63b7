"""What a session measured, live or recorded: series, limits over time, markers. Times are monotonic seconds."""

from abc import abstractmethod
from collections.abc import Collection
from math import inf

import numpy as np
from numpy.typing import NDArray

from app.recordings.excerpt import Excerpt
from app.recordings.markers import Marker, ModuleLimits
from app.recordings.reports import ACTIVE, TRIGGERED
from app.samples.ring_buffers import Readable
from app.samples.step_function import MAX_STEPS, StepFunction


class LimitSteps:
    """The limits of a module over time; the newest `kept` changes of each."""

    def __init__(self, kept: int = MAX_STEPS) -> None:
        self._steps = [StepFunction(kept) for _ in ModuleLimits._fields]
        self.fires, self.rearms, self.falls, self.fall_times, self.lights = self._steps

    def put(self, at: float, limits: ModuleLimits) -> None:
        """Sets the limits from `at` on."""
        for steps, value in zip(self._steps, limits, strict=True):
            steps.put(at, value)

    def at(self, time_s: float = inf) -> ModuleLimits:
        """The limits that held then; by default those of now."""
        held = (steps.between(time_s, time_s) for steps in self._steps)
        return ModuleLimits(*(changes[-1].value if changes else None for changes in held))

    def clear(self) -> None:
        for steps in self._steps:
            steps.clear()


class Measured(LimitSteps):
    """Source of the plots: the current session, or a recording."""

    tilt: Readable
    acceleration: Readable
    cell: Readable
    light: Readable
    markers: Collection[Marker]

    @abstractmethod
    def excerpt(self, start_s: float, end_s: float) -> Excerpt:
        """The data of a span, both ends included."""

    def _excerpt(self, start_s: float, end_s: float, flags: NDArray[np.uint8], *, is_whole: bool = True) -> Excerpt:
        """As views of the series. `flags`: one for each sample of tilt in the span."""
        series = (self.tilt, self.acceleration, self.cell, self.light)
        tilt, acceleration, cell, light = (one.window(start_s, end_s) for one in series)
        return Excerpt(
            start_s=start_s,
            end_s=end_s,
            time_s=tilt.time_s,
            tilt_deg=tilt.value,
            acceleration_g=acceleration.value,
            is_triggered=(flags & TRIGGERED) != 0,
            is_active=(flags & ACTIVE) != 0,
            cell_time_s=cell.time_s,
            cell_voltage_v=cell.value,
            light_time_s=light.time_s,
            light_v=light.value,
            markers=tuple(marker for marker in self.markers if start_s <= marker.time_s <= end_s),
            is_whole=is_whole,
        )
