"""Arrays of samples, for whoever judges them at once."""

from collections.abc import Sequence

import numpy as np

from app.firing.judge import SensorSample
from app.firing.samples import Samples


def samples_of(samples: Sequence[SensorSample], active: Sequence[bool] | None = None) -> tuple[Samples, Samples]:
    """Tilt and acceleration; by default of a module that is active throughout."""
    time_s, tilt_deg, acceleration_g = np.array(samples, np.float64).reshape(-1, 3).T
    is_active = np.full(len(samples), fill_value=True) if active is None else np.array(active, np.bool_)
    return Samples(time_s, tilt_deg, is_active), Samples(time_s, acceleration_g, is_active)
