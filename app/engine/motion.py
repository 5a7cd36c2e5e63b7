"""Measures motion within the last seconds from the module's status reports."""

from collections import deque
from collections.abc import Iterable
from typing import NamedTuple

from protocol.messages import Status

WATCHED_FOR_S = 2.5
# Only the extremes of each slot are kept, as up to 1,440 reports a second may come.
_SLOT_S = 0.1


class MotionExtremes(NamedTuple):
    """The extremes of the reports from `since` to `until` (monotonic seconds)."""

    since: float
    until: float
    tilt_low_deg: float
    tilt_high_deg: float
    acceleration_low_g: float
    acceleration_high_g: float

    @property
    def tilt_change_deg(self) -> float:
        return self.tilt_high_deg - self.tilt_low_deg


class MotionWatch:
    def __init__(self) -> None:
        self._slots: deque[MotionExtremes] = deque()

    def feed(self, status: Status, at: float) -> None:
        tilt, acceleration = status.tilt_deg, status.acceleration_g
        report = MotionExtremes(at, at, tilt, tilt, acceleration, acceleration)
        if self._slots and at - self._slots[-1].since < _SLOT_S:
            self._slots[-1] = _joined((self._slots[-1], report))
        else:
            self._slots.append(report)

    def view(self, now: float) -> MotionExtremes | None:
        """The extremes of the last `WATCHED_FOR_S` seconds, from the start of a slot; None without a report."""
        while self._slots and now - self._slots[0].until > WATCHED_FOR_S:
            self._slots.popleft()
        return _joined(self._slots) if self._slots else None


def _joined(parts: Iterable[MotionExtremes]) -> MotionExtremes:
    since, until, tilt_low, tilt_high, weak, strong = zip(*parts, strict=True)
    return MotionExtremes(since[0], until[-1], min(tilt_low), max(tilt_high), min(weak), max(strong))
