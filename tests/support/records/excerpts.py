"""Makes excerpts of recordings from samples."""

from collections.abc import Iterable, Sequence

import numpy as np

from app.firing.judge import SensorSample
from app.recordings.excerpt import Excerpt
from app.recordings.markers import Marker
from app.samples.ring_buffers import Seconds, Values


def excerpt(
    samples: Sequence[SensorSample],
    *,
    active: Iterable[bool] | None = None,
    markers: tuple[Marker, ...] = (),
    is_whole: bool = True,
) -> Excerpt:
    """Make an excerpt; by default the module is active throughout."""
    times: Seconds = np.array([one.at_s for one in samples], np.float64)
    none: Values = np.empty(0, np.float32)
    flags = np.ones(len(samples), np.bool_) if active is None else np.array(list(active), np.bool_)
    return Excerpt(
        start_s=float(times[0]) if len(times) else 0.0,
        end_s=float(times[-1]) if len(times) else 0.0,
        time_s=times,
        tilt_deg=np.array([one.tilt_deg for one in samples], np.float32),
        acceleration_g=np.array([one.acceleration_g for one in samples], np.float32),
        is_triggered=np.zeros(len(samples), np.bool_),
        is_active=flags,
        cell_time_s=none.astype(np.float64),
        cell_voltage_v=none,
        light_time_s=none.astype(np.float64),
        light_v=none,
        markers=markers,
        is_whole=is_whole,
    )
