"""From the start of the process to the first paint of the window, on the simulated module."""

import statistics
import time
from typing import Final

from tests.benchmarks.figures import Figure
from tests.benchmarks.runs import measured

AIM_S: Final = 0.5


def figures(runs: int = 5) -> list[Figure]:
    """The median, after one run that fills the file system's cache."""
    took = []
    for _ in range(runs + 1):
        began = time.time()
        took.append(float(measured("tests.benchmarks.window.first_paint")["painted_at"]) - began)
    median = statistics.median(took[1:])
    return [
        Figure(
            f"process start to first paint, median of {runs}",
            f"{median:.2f} s ({min(took[1:]):.2f} to {max(took[1:]):.2f}); what takes it: "
            "python -X importtime -m app gui --demo",
            f"<= {AIM_S} s",
            median <= AIM_S,
        )
    ]
