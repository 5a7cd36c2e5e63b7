"""Releases the GIL regularly so that the GUI thread stays responsive."""

import threading
import time

WORK_S = 0.002
REST_S = 0.001
"""At most a third slower, and the window never waits longer than `WORK_S` for its turn."""


class GilYield:
    """`checkpoint` is called often, from one thread; in the main thread it does nothing."""

    def __init__(self) -> None:
        self._is_beside = threading.current_thread() is not threading.main_thread()
        self._rests_at_s = time.perf_counter() + WORK_S

    def checkpoint(self) -> None:
        """Release the GIL for `REST_S` if `WORK_S` have passed."""
        if self._is_beside and time.perf_counter() >= self._rests_at_s:
            time.sleep(REST_S)
            self._rests_at_s = time.perf_counter() + WORK_S
