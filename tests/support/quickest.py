"""Times on a machine that others use too."""

import time
from collections.abc import Callable


def quickest(act: Callable[[], object], *, clock: Callable[[], float] = time.monotonic, times: int = 3) -> float:
    """Seconds of the quickest of several runs: what others do on the machine only ever makes one longer."""
    durations = []
    for _ in range(times):
        began = clock()
        act()
        durations.append(clock() - began)
    return min(durations)
