"""Decides whether the module would fire: attitude and free-fall trigger, as in the vendor's table.

The simulated module and the analysis of flight logs use it. Whoever shows a verdict shows `RULES` and `ASSUMPTIONS`,
too.
"""

from typing import NamedTuple

from protocol.catalogue import RESET_BELOW_THRESHOLD_DEG
from protocol.messages import Source
from protocol.translatable import marked

# A longer pause between two samples ends a fall: what happened in between is unknown.
MAX_GAP_S = 0.5
# Tolerance when durations are compared.
ROUNDING_S = 1e-9
# What the vendor's table says, and what is assumed where it is silent.
RULES = (
    marked("Attitude: fires at its threshold, rearms 10° below."),
    marked("Free fall: fires after the free-fall time below its threshold."),
)
ASSUMPTIONS = (
    marked("Assumed: the threshold tilt fires, the threshold acceleration does not."),
    marked("Assumed: activated while tilted, it fires at once."),
    marked("Assumed: LOCK, a restart or a 0.5 s pause ends a fall."),
)


class SensorSample(NamedTuple):
    """One reading of the sensor. A named tuple: there are 200 a second."""

    at_s: float
    tilt_deg: float
    acceleration_g: float


class TriggerLimits(NamedTuple):
    """The settings that decide, in display units."""

    attitude_threshold_deg: float = 60
    freefall_acceleration_g: float = 0.5
    freefall_time_s: float = 1.6
    attitude_is_enabled: bool = True
    freefall_is_enabled: bool = True

    @property
    def reset_angle_deg(self) -> float:
        return self.attitude_threshold_deg - RESET_BELOW_THRESHOLD_DEG


class SampleVerdict(NamedTuple):
    # Triggers that fire with this sample.
    fired: Source
    # Triggers whose condition still holds: they cannot fire again until it ends.
    standing: Source


NOTHING = Source(0)


class Judge:
    """Judges samples in order; remembers a fall that has begun and triggers that have not reset."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forgets everything, as the module does when it is locked or off."""
        self._standing = NOTHING
        self._falls_since_s: float | None = None
        self._last_s: float | None = None

    def judge(self, sample: SensorSample, limits: TriggerLimits, *, is_active: bool = True) -> SampleVerdict:
        """Times must not decrease. While not active nothing fires and nothing is remembered."""
        if not is_active:
            self.reset()
            return SampleVerdict(NOTHING, NOTHING)
        before = self._standing
        if Source.ATTITUDE in before:
            if sample.tilt_deg <= limits.reset_angle_deg or not limits.attitude_is_enabled:
                self._standing &= ~Source.ATTITUDE
        elif limits.attitude_is_enabled and sample.tilt_deg >= limits.attitude_threshold_deg:
            self._standing |= Source.ATTITUDE
        if not limits.freefall_is_enabled or sample.acceleration_g >= limits.freefall_acceleration_g:
            self._falls_since_s = None
            self._standing &= ~Source.FREEFALL
        else:
            has_gap = self._last_s is not None and sample.at_s - self._last_s > MAX_GAP_S
            if self._falls_since_s is None or has_gap:
                self._falls_since_s = sample.at_s
            if sample.at_s - self._falls_since_s >= limits.freefall_time_s - ROUNDING_S:
                self._standing |= Source.FREEFALL
        self._last_s = sample.at_s
        return SampleVerdict(self._standing & ~before, self._standing)
