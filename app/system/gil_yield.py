"""Releases the GIL regularly so that the GUI thread stays responsive."""

import threading
import time

WORK_S = 0.002
REST_S = 0.001
"""Slows the work by at most a third; the GUI thread waits at most `WORK_S` for the GIL."""


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
