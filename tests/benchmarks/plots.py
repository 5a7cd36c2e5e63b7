"""A redraw of the four plots of the Live page (CPU time, median, 1000 x 500), against pyqtgraph tuned as its
documentation suggests, as in its tutorial, and the painter of version 4a8b7c4c, which drew 60 s at 50 Hz in 1.1 to
1.2 ms and is no longer there to be measured.
"""

from typing import Final

from tests.benchmarks.figures import Figure
from tests.benchmarks.runs import measured

_AIM_MS: Final = 4.0
_CASES: Final = ((60, 50, 60), (60, 1440, 60), (600, 1440, 12))
"""Seconds in sight, reports a second, redraws."""


def figures() -> list[Figure]:
    """One row per case; CPU time, which other work on the machine changes less."""
    found = []
    for window_s, rate_hz, draws in _CASES:
        took = measured("tests.benchmarks.others", str(window_s), str(rate_hz), str(draws))
        naive_ms, tuned_ms, ours_ms = (took[name] * 1000 for name in ("naive_s", "tuned_s", "ours_s"))
        found.append(
            Figure(
                f"{window_s} s in sight at {rate_hz:,} Hz",
                f"{ours_ms:.1f} ms; tuned {tuned_ms:.0f} ms, tutorial {naive_ms:.0f} ms",
                f"<= {_AIM_MS:.0f} ms",
                ours_ms <= _AIM_MS,
            )
        )
    return found
