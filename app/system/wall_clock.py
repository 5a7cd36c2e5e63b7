"""Converts monotonic times to wall-clock times across clock jumps.

During sleep the monotonic clock may stop, and people and time servers set the wall clock. The offset between the two
therefore depends on the time.
"""

import math
import time
from bisect import bisect_left
from datetime import UTC, datetime, timedelta, tzinfo

from app.system.clock import Clock, steady_time

SECOND, MINUTE, DAY = "%Y-%m-%d %H:%M:%S", "%Y-%m-%d %H:%M", "%Y-%m-%d"
JUMP_S = 2.0
"""A larger difference counts as a jump; smaller ones are corrections by a time server."""


class WallClock:
    """Call `poll` often: times between two calls, of which the second detected a jump, count as after the jump. For one
    thread."""

    def __init__(self, clock: Clock = steady_time, wall_clock: Clock = time.time) -> None:
        self._clock, self._wall_clock = clock, wall_clock
        self._polled_at = clock()
        self._froms = [-math.inf]
        self._offsets = [wall_clock() - self._polled_at]

    def poll(self) -> bool:
        """Return whether there was a jump since the last call."""
        before, self._polled_at = self._polled_at, self._clock()
        offset_s = self._wall_clock() - self._polled_at
        if abs(offset_s - self._offsets[-1]) <= JUMP_S:
            return False
        self._froms.append(before)
        self._offsets.append(offset_s)
        return True

    @property
    def offset_s(self) -> float:
        """Add to the current monotonic time to get seconds since 1970."""
        return self._offsets[-1]

    def at(self, time_s: float) -> float:
        """Convert a monotonic time, also an earlier one, to seconds since 1970."""
        return time_s + self._offsets[bisect_left(self._froms, time_s) - 1]


def age_days(at: str, now: datetime) -> float | None:
    """The age of an ISO 8601 time, without zone in UTC; None if it is invalid, or more than a day in the future, as a
    clock was wrong then."""
    try:
        then = datetime.fromisoformat(at)
    except ValueError:
        return None
    days = (now - (then if then.tzinfo is not None else then.replace(tzinfo=UTC))) / timedelta(days=1)
    return None if days < -1 else max(0.0, days)


def local_time(text: str, form: str = SECOND, zone: tzinfo | None = None) -> str:
    """An ISO 8601 time of the store in this zone, by default that of this computer; anything else unchanged."""
    try:
        return datetime.fromisoformat(text).astimezone(zone).strftime(form)
    except (ValueError, OverflowError, OSError):  # some are of no year in this zone
        return text


def clock_text(wall_s: float, decimals: int = 0) -> str:
    """The local time of day of a number of seconds since 1970, with `decimals` of a second."""
    whole = math.floor(round(wall_s, decimals))
    text = time.strftime("%H:%M:%S", time.localtime(whole))
    if not decimals:
        return text
    part = round((wall_s - whole) * 10**decimals)
    return f"{text}.{max(0, part):0{decimals}d}"
