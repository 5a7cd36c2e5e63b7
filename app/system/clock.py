"""The program's clock, and times of day.

During sleep `time.monotonic` stops on Linux and macOS: a value that is twelve minutes old would look fresh, and what
was armed before would still be armed. The time of day is not used: people and time servers set it.
"""

import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime, timedelta, tzinfo
from functools import partial

Clock = Callable[[], float]


# Windows has none of them: its monotonic clock counts sleep itself.
_SLEEPLESS = getattr(time, "CLOCK_MONOTONIC" if sys.platform == "darwin" else "CLOCK_BOOTTIME", None)
# Seconds since some moment. All times (`at`) in the engine are of this clock.
steady_time: Clock = time.monotonic if _SLEEPLESS is None else partial(time.clock_gettime, _SLEEPLESS)

SECOND, MINUTE, DAY = "%Y-%m-%d %H:%M:%S", "%Y-%m-%d %H:%M", "%Y-%m-%d"


def wall_offset_s() -> float:
    """Return what makes a time of `steady_time` seconds since 1970; once a wrong clock was set, also an earlier one."""
    return time.time() - steady_time()


def age_days(at: str, now: datetime) -> float | None:
    """The age of an ISO 8601 time, without zone in UTC; None if it is invalid, or more than a day in the future,
    as a clock was wrong then."""
    try:
        then = datetime.fromisoformat(at)
    except ValueError:
        return None
    days = (now - (then if then.tzinfo is not None else then.replace(tzinfo=UTC))) / timedelta(days=1)
    return None if days < -1 else max(0.0, days)


def local_time(text: str, form: str = SECOND, zone: tzinfo | None = None) -> str:
    """An ISO 8601 time of the store in this zone, by default that of this computer; anything else as it is."""
    try:
        return datetime.fromisoformat(text).astimezone(zone).strftime(form)
    except (ValueError, OverflowError, OSError):  # some are of no year in this zone
        return text


def clock_text(wall_s: float, decimals: int = 0) -> str:
    """The local time of day of seconds since 1970, with `decimals` of a second."""
    text = f"{datetime.fromtimestamp(round(wall_s, decimals)).astimezone():%H:%M:%S.%f}"
    return text[: 9 + decimals] if decimals else text[:8]
