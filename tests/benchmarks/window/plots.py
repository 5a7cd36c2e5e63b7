"""A redraw of the four plots of the Live page, compared in one run with pyqtgraph tuned as its documentation suggests
and as in its tutorial; `PAINTER` is what the hand-written painter took that drew them before.
"""

from typing import Final

from tests.benchmarks.figures import Figure
from tests.benchmarks.runs import measured

_DRAWS: Final = {10: 24, 60: 24, 600: 12}
"""By visible seconds."""


def figures() -> list[Figure]:
    """One row per length of the time line, at line rate."""
    found = []
    for window_s, draws in _DRAWS.items():
        took = measured("tests.benchmarks.others", str(window_s), str(draws))
        naive_s, tuned_s, ours_s = took["naive_s"], took["tuned_s"], took["ours_s"]
        found.append(
            Figure(
                f"draw, {window_s} s in sight, against tuned pyqtgraph",
                f"{tuned_s / ours_s:.1f} x faster ({ours_s * 1000:.1f} ms, tuned {tuned_s * 1000:.1f} ms; as in the "
                f"tutorial {naive_s * 1000:.0f} ms)",
                "faster",
                ours_s < tuned_s,
            )
        )
    return found
