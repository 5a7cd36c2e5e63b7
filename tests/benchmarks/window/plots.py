"""One draw of two curves, against pyqtgraph as in its tutorial: lists that grow, handed over whole."""

from typing import Final

from tests.benchmarks.figures import Figure
from tests.benchmarks.runs import measured

_DRAWS: Final = {10: 12, 60: 12, 600: 4}
"""By the seconds in sight: a naive draw of ten minutes takes seconds."""


def figures() -> list[Figure]:
    """A row for each length of the time line, at line rate."""
    found = []
    for window_s, draws in _DRAWS.items():
        took = measured("tests.benchmarks.others", str(window_s), str(draws))
        naive_s, ours_s = took["naive_s"], took["ours_s"]
        found.append(
            Figure(
                f"draw, {window_s} s in sight, against naive pyqtgraph",
                f"{naive_s / ours_s:.0f} x faster ({ours_s * 1000:.1f} ms, naive {naive_s * 1000:.0f} ms)",
                "faster",
                ours_s < naive_s,
            )
        )
    return found
