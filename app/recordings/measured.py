"""What a session measured, live or recorded: series, limits over time, markers. Times are monotonic seconds."""

from abc import abstractmethod
from collections.abc import Collection
from math import inf

import numpy as np
from numpy.typing import NDArray

from app.recordings.excerpt import Excerpt
from app.recordings.markers import Marker, ModuleLimits
from app.samples.ring_buffers import Readable
from app.samples.step_function import MAX_STEPS, StepFunction


class LimitSteps:
    """The limits of a module over time; the newest `kept` changes of each."""

    def __init__(self, kept: int = MAX_STEPS) -> None:
        self._steps = [StepFunction(kept) for _ in ModuleLimits._fields]
        self.fires, self.rearms, self.falls, self.fall_times, self.lights = self._steps

    def put(self, at: float, limits: ModuleLimits) -> None:
        for steps, value in zip(self._steps, limits, strict=True):
            steps.put(at, value)

    def at(self, time_s: float = inf) -> ModuleLimits:
        """The limits that held then; by default those of now."""
        held = (steps.between(time_s, time_s) for steps in self._steps)
        return ModuleLimits(*(changes[-1].value if changes else None for changes in held))

    def last(self) -> ModuleLimits:
        """What was last known of each."""
        known = ([step.value for step in steps.between(-inf, inf) if step.value is not None] for steps in self._steps)
        return ModuleLimits(*(values[-1] if values else None for values in known))

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
        tilt, acceleration, cell, light = (
            series.window(start_s, end_s) for series in (self.tilt, self.acceleration, self.cell, self.light)
        )
        markers = tuple(marker for marker in self.markers if start_s <= marker.time_s <= end_s)
        return Excerpt(start_s, tilt, acceleration, flags, cell, light, markers, is_whole)
