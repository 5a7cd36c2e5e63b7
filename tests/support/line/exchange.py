"""A line behind which one module follows another, both of which run, at a chosen frame of the host."""

from collections.abc import Mapping
from functools import partial
from typing import Any

from protocol.catalogue import SERIAL_OUTPUT, Hazard, Request
from tests.support.line.frames import at_each_frame, at_frame
from tests.support.line.lies import lying_bench
from tests.support.line.sim_line import Rig, watched

GAP_S = 0.5
"""While the cable is in nobody's hands: longer than a silence that is noticed, shorter than one that is asked about."""
_FIRST: Mapping[str, Any] = {"uptime": 60, "noise": 0, "boots": 37, "rate": 10, "history": 3, "seed": 1}
_SECOND: Mapping[str, Any] = {"uptime": 60, "noise": 0, "rate": 10, "history": 5, "seed": 2}
_SETTINGS = {"attitude_threshold": 85, "light_threshold": 70, "freefall_acceleration": 4, "freefall_time": 60}


class ExchangedRig(Rig):
    """A session of the window on a module without a name; another one with `boots` follows at the frame `at`, which is
    lost."""

    def __init__(self, at: int, *, boots: int = 90) -> None:
        super().__init__(_FIRST, is_attended=True)
        self.first, self.second = self.bench, lying_bench({**_SECOND, "boots": boots}, self.clock)
        for name, value in _SETTINGS.items():
            setattr(self.second.module.memory, name, value)
        self._arrived = list[Request]()
        at_each_frame(self.second, self._arrived.append)
        watched(self)
        self.step_for(3.0)
        self.exchange_at(at)

    def exchange_at(self, frame: int) -> None:
        at_frame(self.first, frame, partial(self.line.lead_to, self.second, GAP_S), is_lost=True)

    @property
    def is_exchanged(self) -> bool:
        return self.bench is self.second

    @property
    def to_second(self) -> list[Request]:
        """What was not a query, and not for the stream."""
        return [one for one in self._arrived if one.hazard is not Hazard.NONE and one.command is not SERIAL_OUTPUT]
