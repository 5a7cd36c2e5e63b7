"""Detects that the computer slept, by comparing two clocks.

During sleep the monotonic clock may stop: a value that is twelve minutes old would look fresh, and what was armed
before would still be armed.

- The system tells how long it slept: by a clock that includes sleep (Linux, macOS), or by two interrupt times, one of
  which excludes sleep (Windows).
- A virtual machine that was paused is detected by an iteration of the loop that took far too long.

The time of day is not used: people and time servers set it.
"""

import sys
import time
from collections.abc import Callable
from functools import partial

SHORTEST_S = 1.0
"""The shortest sleep; smaller differences come from reading two clocks one after the other."""
MAX_TURN_S = 5.0
"""An iteration of the loop waits 0.02 s, and works up to a second on a slow disk."""

_INTERRUPT_TIMES_PER_S = 10_000_000

Clock = Callable[[], float]


def sleepless_clock() -> Clock | None:
    """`time.monotonic` plus the time asleep; None if the system does not provide it."""
    if sys.platform == "win32":
        return plus_time_asleep(time.monotonic, *_interrupt_times())
    else:  # noqa: RET505  mypy would call it unreachable
        name = "CLOCK_MONOTONIC" if sys.platform == "darwin" else "CLOCK_BOOTTIME"
        number: int | None = getattr(time, name, None)
        if number is None or not hasattr(time, "clock_gettime"):
            return None
        return partial(time.clock_gettime, number)


def plus_time_asleep(clock: Clock, with_sleep: Clock, without_sleep: Clock) -> Clock:
    """`clock` plus the difference of the other two; works whether or not `clock` includes sleep."""
    return lambda: clock() + with_sleep() - without_sleep()


if sys.platform == "win32":
    import ctypes

    def _interrupt_times() -> tuple[Clock, Clock]:
        """The interrupt time with and without sleep and hibernation, both as of the last clock interrupt."""
        base = ctypes.WinDLL("kernelbase")

        def reads(name: str) -> Clock:
            query = getattr(base, name)

            def read() -> float:
                count = ctypes.c_uint64()
                query(ctypes.byref(count))
                return count.value / _INTERRUPT_TIMES_PER_S

            return read

        return reads("QueryInterruptTime"), reads("QueryUnbiasedInterruptTime")


class SleepDetector:
    """Compares two clocks with their last reading. `with_sleep`: None if the system has no such clock. For one
    thread."""

    def __init__(self, clock: Clock = time.monotonic, with_sleep: Clock | None = None) -> None:
        self._clock, self._with_sleep = clock, with_sleep
        self._before = self._now()

    def poll(self) -> float:
        """How long the computer slept since the last call, in seconds."""
        (awake_s, with_sleep_s), self._before = self._before, self._now()
        turn_s, with_sleep_s = self._before[0] - awake_s, self._before[1] - with_sleep_s
        if with_sleep_s - turn_s >= SHORTEST_S:
            return with_sleep_s - turn_s
        return turn_s if turn_s >= MAX_TURN_S else 0.0

    def _now(self) -> tuple[float, float]:
        awake_s = self._clock()
        return awake_s, awake_s if self._with_sleep is None else self._with_sleep()
