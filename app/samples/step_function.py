"""Bounded step function: a value that holds until the next change."""

from collections import deque
from typing import Final, NamedTuple

MAX_STEPS: Final = 1000
"""Changes of one setting."""


class StepPoint(NamedTuple):
    """The value from this time on; None: unknown."""

    time_s: float
    value: float | None


class StepFunction:
    """A setting over time: each value holds until the next one. The newest `kept` changes are kept."""

    def __init__(self, kept: int = MAX_STEPS) -> None:
        self._changes: deque[StepPoint] = deque(maxlen=kept)

    def clear(self) -> None:
        self._changes.clear()

    @property
    def value(self) -> float | None:
        """The present value, None if unknown."""
        return self._changes[-1].value if self._changes else None

    def put(self, time_s: float, value: float | None) -> None:
        """Set the value from now on; None: unknown. Raises ValueError for an earlier time."""
        newest = self._changes[-1] if self._changes else None
        if newest is not None and time_s < newest.time_s:
            raise ValueError("times run backwards")
        if newest is None or value != newest.value:
            self._changes.append(StepPoint(time_s, value))

    def between(self, start_s: float, end_s: float) -> list[StepPoint]:
        """The value at `start_s`, if there is one, and every change up to `end_s`."""
        points: list[StepPoint] = []
        for change in reversed(self._changes):
            if change.time_s <= end_s:
                points.append(change)
                if change.time_s <= start_s:
                    break
        return points[::-1]
