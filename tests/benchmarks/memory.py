"""Memory of the window after ten hours at line rate, and its further growth.

The plots' buffers for ten hours are filled before. In use they grow by about 1.6 MB an hour for the first twelve hours.
"""

import statistics
import sys
from typing import Final

from tests.benchmarks.figures import Figure
from tests.benchmarks.runs import measured

HOURS: Final = 10
AIM_MB_PER_H: Final = 0.5
"""A tenth of a byte per frame."""


def figures(full_s: float = 12.0) -> list[Figure]:
    """Measured from the second hour on, when everything limited by count has reached its limit."""
    name = f"memory after {HOURS} simulated hours at 1,440 Hz"
    if not sys.platform.startswith("linux"):
        return [Figure(name, "not measured: only Linux tells it here")]
    found = measured("tests.benchmarks.hours", str(HOURS), f"{full_s:g}")
    memory = found["memory_mb"]
    later = memory[2:]
    slope = statistics.linear_regression(range(len(later)), later).slope
    return [
        Figure(
            f"{name} ({found['frames'] / 1e6:.1f} million frames, {HOURS * full_s / 60:.0f} min the whole way)",
            f"{memory[-1]:.0f} MB; {memory[0]:.0f} at the start, {memory[1]:.0f} after one hour, {slope:+.2f} MB/h",
            f"flat: <= {AIM_MB_PER_H} MB/h",
            slope <= AIM_MB_PER_H,
        )
    ]
