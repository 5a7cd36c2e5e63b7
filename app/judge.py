"""Would the module fire?  Its own two triggers, attitude and free fall, as the vendor's table describes them.

Pure: samples in, triggers out. The simulated module judges with it, and so can whoever holds a recording.

What the table says: attitude fires at the threshold angle and resets ten degrees below it; free fall fires when the
acceleration stays below its threshold for the free-fall time; a locked module is in standby. What it does not say, and
what is assumed here: the threshold itself fires, the acceleration threshold itself does not, a module that is activated
while tilted fires at once, and standby forgets a fall that had begun.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from protocol.catalogue import RESET_BELOW_THRESHOLD_DEG
from protocol.messages import Source

LONGEST_GAP_S = 0.5
"""A pause between two samples longer than this proves nothing about the fall in between."""

_ROUNDING_S = 1e-9


class Sample(NamedTuple):
    """One reading of the sensor. A named tuple: there are 200 a second."""

    at_s: float
    tilt_deg: float
    acceleration_g: float


@dataclass(frozen=True, slots=True)
class Limits:
    """The settings that decide, in the units that a person reads."""

    attitude_threshold_deg: float = 60
    freefall_acceleration_g: float = 0.5
    freefall_time_s: float = 1.6
    attitude_is_enabled: bool = True
    freefall_is_enabled: bool = True

    @property
    def reset_angle_deg(self) -> float:
        return self.attitude_threshold_deg - RESET_BELOW_THRESHOLD_DEG


class Verdict(NamedTuple):
    """What one sample did."""

    fired: Source
    """Triggers that fire with this sample; none for most."""
    standing: Source
    """Triggers whose condition still holds: they cannot fire again before it is over."""


NOTHING = Source(0)


class Judge:
    """Judges one sample after the other; remembers a fall that has begun and triggers that have not reset."""

    def __init__(self) -> None:
        self._standing = NOTHING
        self._falls_since_s: float | None = None
        self._last_s: float | None = None

    def stand_by(self) -> None:
        """Forget everything: the module is locked, or was off."""
        self._standing = NOTHING
        self._falls_since_s = None
        self._last_s = None

    def judge(self, sample: Sample, limits: Limits, *, is_active: bool = True) -> Verdict:
        """Times must not go back. While not active nothing fires and nothing is remembered."""
        if not is_active:
            self.stand_by()
            return Verdict(NOTHING, NOTHING)
        before = self._standing
        self._judge_attitude(sample, limits)
        self._judge_fall(sample, limits)
        self._last_s = sample.at_s
        return Verdict(self._standing & ~before, self._standing)

    def _judge_attitude(self, sample: Sample, limits: Limits) -> None:
        if Source.ATTITUDE in self._standing:
            if sample.tilt_deg <= limits.reset_angle_deg or not limits.attitude_is_enabled:
                self._standing &= ~Source.ATTITUDE
        elif limits.attitude_is_enabled and sample.tilt_deg >= limits.attitude_threshold_deg:
            self._standing |= Source.ATTITUDE

    def _judge_fall(self, sample: Sample, limits: Limits) -> None:
        if not limits.freefall_is_enabled or sample.acceleration_g >= limits.freefall_acceleration_g:
            self._falls_since_s = None
            self._standing &= ~Source.FREEFALL
            return
        has_gap = self._last_s is not None and sample.at_s - self._last_s > LONGEST_GAP_S
        if self._falls_since_s is None or has_gap:
            self._falls_since_s = sample.at_s
        if sample.at_s - self._falls_since_s >= limits.freefall_time_s - _ROUNDING_S:
            self._standing |= Source.FREEFALL


class Firing(NamedTuple):
    """A sample at which the module would have fired, and why."""

    sample: Sample
    sources: Source


def firings(samples: Iterable[Sample], limits: Limits) -> Iterator[Firing]:
    """Where an active module with these limits would have fired in a recording."""
    judge = Judge()
    for sample in samples:
        fired = judge.judge(sample, limits).fired
        if fired:
            yield Firing(sample, fired)
