"""Detects that the computer slept, by comparing two clocks.

While the computer sleeps nothing is heard of the module, and the clock that ages are told by may stand still: what is
twelve minutes old would pass for fresh, and what was armed before would be armed still.

- The system tells how long it slept: by a clock that goes on asleep (Linux, macOS), or by two counts of interrupt
  time, of which one leaves sleep out (Windows).
- A machine that was stopped as a whole knows nothing of it: a turn of the loop took far longer than it ever waits.

The time of day says nothing: people and time servers set it.
"""

import sys
import time
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

SHORTEST_S = 1.0
"""A sleep; less than that is two clocks that were not read at the same instant."""
MAX_TURN_S = 5.0
"""A turn of the loop waits for 0.02 s, and works for a second where the disk is slow."""

_INTERRUPT_TIMES_PER_S = 10_000_000

Clock = Callable[[], float]


class ClockReading(NamedTuple):
    """Both clocks at one instant, in seconds. `with_sleep_s` is None where the system does not tell of sleep."""

    awake_s: float
    with_sleep_s: float | None = None


def slept_s(before: ClockReading, now: ClockReading) -> float:
    """For how long it slept between two moments; 0 where it did not."""
    turn_s = now.awake_s - before.awake_s
    if before.with_sleep_s is not None and now.with_sleep_s is not None:
        missed_s = now.with_sleep_s - before.with_sleep_s - turn_s
        if missed_s >= SHORTEST_S:
            return missed_s
    return turn_s if turn_s >= MAX_TURN_S else 0.0


def sleepless_clock() -> Clock | None:
    """`time.monotonic` plus the time that the computer slept; None where the system does not tell."""
    if sys.platform == "win32":
        return plus_time_asleep(time.monotonic, *_interrupt_times())
    else:  # noqa: RET505  mypy would call it unreachable
        name = "CLOCK_MONOTONIC" if sys.platform == "darwin" else "CLOCK_BOOTTIME"
        number: int | None = getattr(time, name, None)
        if number is None or not hasattr(time, "clock_gettime"):
            return None
        return partial(time.clock_gettime, number)


def plus_time_asleep(clock: Clock, with_sleep: Clock, without_sleep: Clock) -> Clock:
    """`clock` plus what the other two disagree about; whether `clock` itself goes on asleep does not matter."""
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
    """Compares each look with the one before. One thread."""

    def __init__(self, clock: Clock = time.monotonic, with_sleep: Clock | None = None) -> None:
        self._clock, self._with_sleep = clock, with_sleep
        self._before = self._now()

    def poll(self) -> float:
        """For how long the computer slept since the last look, in seconds; 0 where it did not."""
        now = self._now()
        before, self._before = self._before, now
        return slept_s(before, now)

    def _now(self) -> ClockReading:
        return ClockReading(self._clock(), None if self._with_sleep is None else self._with_sleep())
