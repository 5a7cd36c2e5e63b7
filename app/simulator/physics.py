"""Physics of the simulated module: attitude, fall, light and cell voltage.

Uses no clock: all methods take the time, in seconds of one monotonic clock.
"""

import math
import random
from dataclasses import dataclass
from typing import NamedTuple

GRAVITY_M_S2 = 9.81
FALLING_G = 0.02  # air drag leaves a little
IMPACT_G = 14.0
IMPACT_S = 0.06
OPENING_S = 0.2
"""From the trigger until the parachute opens; until then it still falls."""
OPENING_SHOCK_G = 3.2
OPENING_SHOCK_S = 0.3
FULL_CELL_V = 4.2
EMPTY_CELL_V = 3.0
CHARGE_V_PER_H = 1.2
CHARGER_LIFT_V = 0.1  # "有外接电源测量有误差": while charging the charger's voltage is read, not the cell's
LIGHT_BAY_CLOSED_V = 0.3
LIGHT_BAY_OPEN_V = 2.5
SENSOR_PERIOD_S = 0.005

_NOISE_LENGTH = 1021  # a prime, so that the four channels below never fall into step


class SensedMotion(NamedTuple):
    tilt_deg: float
    """Signed angle of the aircraft against the horizontal plane, before zeroing."""
    acceleration_g: float


@dataclass(slots=True)
class _Fall:
    begins_s: float
    ends_s: float
    end_g: float = IMPACT_G
    """Acceleration at its end, by the ground or by the opening parachute."""
    end_lasts_s: float = IMPACT_S


@dataclass(slots=True, kw_only=True)
class Physics:
    """The public fields but `noise` may be set after `advance`."""

    tilt_deg: float = 0.0
    bay_is_open: bool = False
    has_external_power: bool = False
    cell_v: float = 3.9
    drain_v_per_h: float = 0.05
    noise: float = 0.0
    """0: ideal sensor, 1: typical sensor."""
    is_lifelike: bool = False
    """Wobbles by a few degrees, as in a hand."""
    seed: int = 1
    _now_s: float = -math.inf
    _fall: _Fall | None = None
    _noise: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        source = random.Random(self.seed)  # noqa: S311 (noise, not secrets)
        self._noise = tuple(source.gauss(0.0, 1.0) for _ in range(_NOISE_LENGTH)) if self.noise else ()

    def advance(self, now_s: float) -> None:
        """Advance the time: the cell drains or charges. The time never goes back."""
        if now_s <= self._now_s:
            return
        if self._now_s != -math.inf:
            hours = (now_s - self._now_s) / 3600
            if self.has_external_power:
                self.cell_v = max(self.cell_v, min(FULL_CELL_V, self.cell_v + CHARGE_V_PER_H * hours))
            else:
                self.cell_v = min(self.cell_v, max(EMPTY_CELL_V, self.cell_v - self.drain_v_per_h * hours))
        self._now_s = now_s

    def drop(self, height_m: float, now_s: float) -> None:
        """Start a free fall from this height, without drag."""
        self._fall = _Fall(now_s, now_s + math.sqrt(2 * max(0.0, height_m) / GRAVITY_M_S2))

    def open_parachute(self, now_s: float) -> None:
        """The module has fired: the bay opens, and the parachute ends a fall."""
        self.bay_is_open = True
        fall = self._fall
        if fall is not None and fall.begins_s <= now_s < fall.ends_s:
            opens_s = now_s + OPENING_S
            if opens_s < fall.ends_s:
                self._fall = _Fall(fall.begins_s, opens_s, OPENING_SHOCK_G, OPENING_SHOCK_S)

    def is_falling(self, now_s: float) -> bool:
        return self._fall is not None and self._fall.begins_s <= now_s < self._fall.ends_s

    @property
    def is_at_rest(self) -> bool:
        """`motion` is the same at any time."""
        return not (self.noise or self.is_lifelike or self._fall)

    def motion(self, at_s: float) -> SensedMotion:
        tilt, acceleration = self.tilt_deg, 1.0
        if self.is_lifelike:
            tilt += 4.0 + 2.4 * math.sin(0.83 * at_s) + 1.1 * math.sin(2.27 * at_s + 1.0)
            acceleration += 0.06 * math.sin(1.7 * at_s) + 0.05 * math.sin(5.1 * at_s)
        fall = self._fall
        if fall is not None and at_s >= fall.begins_s:
            if at_s < fall.ends_s:
                acceleration = FALLING_G
            elif at_s < fall.ends_s + fall.end_lasts_s:
                acceleration = fall.end_g
        tilt += 0.4 * self._noise_at(at_s, 0)
        acceleration += 0.03 * self._noise_at(at_s, 211)
        return SensedMotion(tilt, max(0.0, acceleration))

    def light_v(self, at_s: float) -> float:
        """Voltage of the light sensor in the bay, which reads higher in light (E11)."""
        volts = LIGHT_BAY_OPEN_V if self.bay_is_open else LIGHT_BAY_CLOSED_V
        return max(0.0, volts + 0.03 * self._noise_at(at_s, 433))

    def voltage_v(self, at_s: float) -> float:
        """The measured voltage: of the cell, or with external power the charging voltage."""
        lift = CHARGER_LIFT_V if self.has_external_power else 0.0
        return self.cell_v + lift + 0.005 * self._noise_at(at_s, 641)

    def _noise_at(self, at_s: float, channel: int) -> float:
        """A function of time and seed."""
        if not self.noise:
            return 0.0
        return self.noise * self._noise[(int(at_s / SENSOR_PERIOD_S) + channel) % _NOISE_LENGTH]
