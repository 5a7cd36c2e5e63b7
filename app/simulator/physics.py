"""The world of the simulated module: attitude, fall, light and cell voltage.

It has no clock: every method takes the time, in seconds of one monotonic clock. The cell neither drains nor charges:
its voltage is what somebody sets.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

GRAVITY_M_S2 = 9.81
FALLING_G = 0.02  # air drag leaves a little
IMPACT_G = 14.0
OPENING_SHOCK_G = 3.2
JOLT_S = 0.1  # how long the impact or the opening shock lasts
OPENING_S = 0.2  # from the trigger until the parachute holds; the module falls until then
CHARGER_LIFT_V = 0.1  # "有外接电源测量有误差": with external power its voltage is read, not the cell's
LIGHT_BAY_CLOSED_V = 0.3
LIGHT_BAY_OPEN_V = 2.5  # more light reads higher (E11)
SENSOR_PERIOD_S = 0.005


class SensedMotion(NamedTuple):
    """The tilt is signed, against the horizontal plane, before zeroing."""

    tilt_deg: float
    acceleration_g: float


@dataclass(slots=True, kw_only=True)
class Physics:
    """Its public fields may be changed at any time. A lifelike module moves by a few degrees, as in somebody's hand."""

    tilt_deg: float = 0.0
    bay_is_open: bool = False
    has_external_power: bool = False
    cell_v: float = 3.9
    is_lifelike: bool = False
    _falls_from_s: float = math.inf
    _falls_until_s: float = -math.inf
    _jolt_g: float = IMPACT_G

    def drop(self, height_m: float, now_s: float) -> None:
        """Let it fall freely from this height."""
        self._falls_from_s = now_s
        self._falls_until_s = now_s + math.sqrt(2 * max(0.0, height_m) / GRAVITY_M_S2)
        self._jolt_g = IMPACT_G

    def open_parachute(self, now_s: float) -> None:
        """The module has fired: the bay is open, and a fall ends as soon as the parachute holds."""
        self.bay_is_open = True
        if self.is_falling(now_s) and now_s + OPENING_S < self._falls_until_s:
            self._falls_until_s = now_s + OPENING_S
            self._jolt_g = OPENING_SHOCK_G

    def is_falling(self, now_s: float) -> bool:
        return self._falls_from_s <= now_s < self._falls_until_s

    def is_at_rest(self, now_s: float) -> bool:
        """Return whether `motion` stays as it is now until somebody moves it."""
        return not self.is_lifelike and now_s >= self._falls_until_s + JOLT_S

    def motion(self, at_s: float) -> SensedMotion:
        tilt_deg = self.tilt_deg
        acceleration_g = 1.0
        if self.is_lifelike:
            tilt_deg += 4.0 + 2.4 * math.sin(0.83 * at_s) + 1.1 * math.sin(2.27 * at_s + 1.0)
            acceleration_g += 0.06 * math.sin(1.7 * at_s) + 0.05 * math.sin(5.1 * at_s)
        if self.is_falling(at_s):
            acceleration_g = FALLING_G
        elif self._falls_until_s <= at_s < self._falls_until_s + JOLT_S:
            acceleration_g = self._jolt_g
        return SensedMotion(tilt_deg, acceleration_g)

    @property
    def light_v(self) -> float:
        """The voltage of the light sensor in the bay."""
        return LIGHT_BAY_OPEN_V if self.bay_is_open else LIGHT_BAY_CLOSED_V

    @property
    def voltage_v(self) -> float:
        """The measured voltage: of the cell, or with external power the charging voltage."""
        return self.cell_v + (CHARGER_LIFT_V if self.has_external_power else 0.0)
