"""Measures motion within the last seconds from the module's status reports."""

from collections import deque
from typing import Final, NamedTuple

from protocol.messages import Status

WATCHED_FOR_S: Final = 2.5
_SLOT_S: Final = 0.1
"""Only the extremes of each slot are kept, as up to 1,440 reports a second may come."""


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

    def joined(self, other: "MotionExtremes") -> "MotionExtremes":
        return MotionExtremes(
            min(self.since, other.since),
            max(self.until, other.until),
            min(self.tilt_low_deg, other.tilt_low_deg),
            max(self.tilt_high_deg, other.tilt_high_deg),
            min(self.acceleration_low_g, other.acceleration_low_g),
            max(self.acceleration_high_g, other.acceleration_high_g),
        )


class MotionWatch:
    def __init__(self) -> None:
        self._slots: deque[MotionExtremes] = deque()

    def clear(self) -> None:
        self._slots.clear()

    def feed(self, status: Status, at: float) -> None:
        tilt, acceleration = status.tilt_deg, status.acceleration_g
        report = MotionExtremes(at, at, tilt, tilt, acceleration, acceleration)
        if self._slots and at - self._slots[-1].since < _SLOT_S:
            self._slots[-1] = self._slots[-1].joined(report)
        else:
            self._slots.append(report)

    def view(self, now: float) -> MotionExtremes | None:
        """The extremes of the last `WATCHED_FOR_S` seconds, from the start of a slot; None without a report."""
        slots = self._slots
        while slots and now - slots[0].until > WATCHED_FOR_S:
            slots.popleft()
        if not slots:
            return None
        # By columns: nine times quicker than joining one after the other, for every view of every module.
        since, until, tilt_low, tilt_high, acceleration_low, acceleration_high = zip(*slots, strict=True)
        return MotionExtremes(
            since[0], until[-1], min(tilt_low), max(tilt_high), min(acceleration_low), max(acceleration_high)
        )
