"""Makes excerpts of recordings from samples."""

from collections.abc import Iterable, Sequence

import numpy as np

from app.firing.judge import SensorSample
from app.recordings.excerpt import Excerpt
from app.recordings.markers import Marker
from app.recordings.reports import ACTIVE
from app.samples.ring_buffers import Window


def excerpt(
    samples: Sequence[SensorSample],
    *,
    active: Iterable[bool] | None = None,
    markers: tuple[Marker, ...] = (),
    is_whole: bool = True,
) -> Excerpt:
    """Make an excerpt; by default the module is active throughout."""
    times = np.array([one.at_s for one in samples], np.float64)
    tilts, accelerations = (
        Window(times, np.array(values, np.float32))
        for values in ([one.tilt_deg for one in samples], [one.acceleration_g for one in samples])
    )
    flags = np.full(len(samples), ACTIVE) if active is None else np.array(list(active)) * np.uint8(ACTIVE)
    none = Window(times[:0], np.empty(0, np.float32))
    start_s = float(times[0]) if len(times) else 0.0
    return Excerpt(start_s, tilts, accelerations, flags.astype(np.uint8), none, none, markers, is_whole)
