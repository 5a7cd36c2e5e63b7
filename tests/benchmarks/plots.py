"""A redraw of the four plots of the Live page, compared in one run with pyqtgraph tuned as its documentation suggests
and as in its tutorial; `PAINTER` is what the hand-written painter took that drew them before.
"""

from typing import Final

from tests.benchmarks.figures import Figure
from tests.benchmarks.runs import measured

AIM_S: Final = 0.004
PAINTER: Final = "1.1 to 1.2 ms"
"""Of version 4a8b7c4c at 60 s and 50 Hz, two loaded cores; it is no longer there to be measured."""
_CASES: Final = ((60, 50, 60), (60, 1440, 60), (600, 1440, 12))
"""Seconds in sight, reports a second, redraws."""


def figures() -> list[Figure]:
    """One row per case; CPU time, which other work on the machine changes less."""
    found = []
    for window_s, rate_hz, draws in _CASES:
        took = measured("tests.benchmarks.others", str(window_s), str(rate_hz), str(draws))
        naive_s, tuned_s, ours_s = took["naive_s"], took["tuned_s"], took["ours_s"]
        found.append(
            Figure(
                f"redraw of four plots, {window_s} s in sight at {rate_hz:,} Hz",
                f"{ours_s * 1000:.1f} ms of CPU; pyqtgraph tuned {tuned_s * 1000:.1f} ms, as in its tutorial "
                f"{naive_s * 1000:.0f} ms; the painter of version 4a8b7c4c {PAINTER}",
                f"<= {AIM_S * 1000:.0f} ms",
                ours_s <= AIM_S,
            )
        )
    return found
