"""Time of a draw of the plots, and stalls of the event loop, at line rate."""

import statistics
import threading
import time
from typing import Final, Self

from tests.benchmarks.figures import Figure
from tests.benchmarks.runs import lively_module, measured
from tests.benchmarks.window.window import BEAT_MS, LINE_HZ

DRAW_AIM_S: Final = 0.010
STALL_AIM_S: Final = 0.050
_WINDOWS_S: Final = (10, 60, 600)
_RUNS: Final = 3


class _Idler:
    """Sleeps repeatedly in an idle process: how late the machine itself wakes a process."""

    def __init__(self) -> None:
        self.longest_late_s = 0.0
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._sleep, name="idler")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._is_over.set()
        self._thread.join()

    def _sleep(self) -> None:
        while not self._is_over.is_set():
            began = time.perf_counter()
            time.sleep(BEAT_MS / 1000)
            self.longest_late_s = max(self.longest_late_s, time.perf_counter() - began - BEAT_MS / 1000)


def figures(seconds: float = 6.0) -> list[Figure]:
    """Draws per length of the full time line; stalls over all runs."""
    found, stalls = [], []
    with _Idler() as idler:
        for window_s in _WINDOWS_S:
            runs = []
            for _ in range(_RUNS if window_s == _WINDOWS_S[1] else 1):
                with lively_module(LINE_HZ) as module:
                    watch = ("--watch", str(window_s))
                    runs.append(measured("tests.benchmarks.window.window", module.port, str(seconds), *watch))
            stalls += [run["stall_s"] for run in runs]
            median, p99, longest = (
                statistics.median(run[key] for run in runs) for key in ("draw_median_s", "draw_p99_s", "draw_longest_s")
            )
            found.append(
                Figure(
                    f"draw of the plots, {window_s} s in sight ({sum(run['draws'] for run in runs)} draws)",
                    f"median {median * 1000:.1f} ms, 99 % {p99 * 1000:.1f} ms, longest {longest * 1000:.1f} ms",
                    f"99 % <= {DRAW_AIM_S * 1000:.0f} ms",
                    p99 <= DRAW_AIM_S,
                )
            )
    stall = statistics.median(stalls)
    found.append(
        Figure(
            f"longest stall of the event loop, median of {len(stalls)} runs",
            f"{stall * 1000:.1f} ms (worst {max(stalls) * 1000:.1f} ms; an idle program: "
            f"{idler.longest_late_s * 1000:.1f} ms)",
            f"<= {STALL_AIM_S * 1000:.0f} ms",
            stall <= STALL_AIM_S,
        )
    )
    return found
