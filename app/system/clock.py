"""The program's clock: seconds that never go back, and that count while the computer sleeps.

During sleep `time.monotonic` stops on Linux and macOS: a value that is twelve minutes old would look fresh, and what
was armed before would still be armed. The time of day is not used: people and time servers set it.
"""

import sys
import time
from collections.abc import Callable
from functools import partial

Clock = Callable[[], float]


def _sleepless_clock() -> Clock:
    # Windows' monotonic clock counts sleep itself.
    name = "CLOCK_MONOTONIC" if sys.platform == "darwin" else "CLOCK_BOOTTIME"
    number: int | None = getattr(time, name, None)
    if number is None:
        return time.monotonic
    return partial(time.clock_gettime, number)


steady_time: Clock = _sleepless_clock()
"""Seconds since some moment. All times (`at`) in the engine are of this clock."""
