"""Excerpt of measured data between two times."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.recordings.markers import Marker
from app.samples.ring_buffers import Seconds, Values


@dataclass(frozen=True, slots=True)
class Excerpt:
    """Immutable. Times are monotonic seconds; the columns of a group have the same length."""

    start_s: float
    end_s: float
    time_s: Seconds
    tilt_deg: Values
    acceleration_g: Values
    is_triggered: NDArray[np.bool_]
    is_active: NDArray[np.bool_]
    cell_time_s: Seconds
    cell_voltage_v: Values
    light_time_s: Seconds
    light_v: Values
    markers: tuple[Marker, ...]
    is_whole: bool = True
    """False where the span includes times that are no longer kept sample by sample."""

    @property
    def first_s(self) -> float:
        """Time of the first row; the start of the span where it is empty."""
        firsts = [float(times[0]) for times in (self.time_s, self.cell_time_s, self.light_time_s) if len(times)]
        return min((*firsts, *(one.time_s for one in self.markers)), default=self.start_s)

    @property
    def row_count(self) -> int:
        """Number of samples and markers."""
        return len(self.time_s) + len(self.cell_time_s) + len(self.light_time_s) + len(self.markers)
