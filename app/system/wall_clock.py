"""Converts monotonic times to wall-clock times across clock jumps.

While the computer sleeps the monotonic clock may stand still, and people and time servers set the calendar's. So what
is to be added to a monotonic time depends on when that was.
"""

import math
import time
from bisect import bisect_left
from datetime import datetime

from app.system.sleep_detector import Clock

JUMP_S = 2.0
"""So far the two clocks may go apart before that counts; less is a time server at work."""


class WallClock:
    """`look` often: a time between two looks, of which only the second found the clocks apart, is taken as from after
    that. One thread."""

    def __init__(self, clock: Clock = time.monotonic, wall_clock: Clock = time.time) -> None:
        self._clock, self._wall_clock = clock, wall_clock
        self._polled_at = clock()
        self._froms = [-math.inf]
        self._offsets = [wall_clock() - self._polled_at]

    def poll(self) -> bool:
        """Whether the clocks went apart since the last look."""
        before, self._polled_at = self._polled_at, self._clock()
        offset_s = self._wall_clock() - self._polled_at
        if abs(offset_s - self._offsets[-1]) <= JUMP_S:
            return False
        self._froms.append(before)
        self._offsets.append(offset_s)
        return True

    @property
    def offset_s(self) -> float:
        """Added to a monotonic time of now gives seconds since 1970."""
        return self._offsets[-1]

    def at(self, time_s: float) -> float:
        """A monotonic time, also an earlier one, as seconds since 1970."""
        return time_s + self._offsets[bisect_left(self._froms, time_s) - 1]


def local_time(text: str) -> str:
    """An ISO 8601 time of the store in this computer's time zone; anything else unchanged."""
    try:
        return f"{datetime.fromisoformat(text).astimezone():%Y-%m-%d %H:%M:%S}"
    except ValueError:
        return text
