"""A line behind which one module follows another, both of which run, at a chosen frame of the host."""

from collections.abc import Mapping
from functools import partial
from typing import Any

from protocol.catalogue import Hazard, Request
from tests.support.line.frames import at_each_frame, at_frame
from tests.support.line.odd_module import odd_bench
from tests.support.line.sim_line import Rig

GAP_S = 0.5
"""While the cable is in nobody's hands: the shortest silence that is noticed for certain."""
_FIRST: Mapping[str, Any] = {"uptime": 60, "noise": 0, "boots": 37, "rate": 10, "history": 3, "seed": 1}
_SECOND: Mapping[str, Any] = {"uptime": 60, "noise": 0, "rate": 10, "history": 5, "seed": 2}
_SETTINGS = {"attitude_threshold": 85, "light_threshold": 70, "freefall_acceleration": 4, "freefall_time": 60}


class ExchangedRig(Rig):
    """A conversation with a module; another one with `boots` follows at the frame `at` of those that are still to be
    sent, which is lost."""

    def __init__(self, at: int, *, boots: int = 90, gap_s: float = GAP_S, **first: Any) -> None:
        super().__init__({**_FIRST, **first})
        self.first, self.second = self.bench, odd_bench({**_SECOND, "boots": boots}, self.clock)
        for name, value in _SETTINGS.items():
            setattr(self.second.module.memory, name, value)
        self._arrived = list[Request]()
        at_each_frame(self.second, self._arrived.append)
        self.begin()
        at_frame(self.first, at, partial(self.line.lead_to, self.second, gap_s), is_lost=True)

    @property
    def is_exchanged(self) -> bool:
        return self.bench is self.second

    @property
    def to_second(self) -> list[Request]:
        """What reached it and was not a question."""
        return [one for one in self._arrived if one.hazard is not Hazard.NONE]
