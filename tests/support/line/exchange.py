"""A line behind which one module follows another, both of which run, at a chosen frame of the host."""

from collections.abc import Mapping
from typing import Any

from app.engine.session import Session
from app.simulator.bench import SimulatedBench
from protocol.catalogue import Hazard, Request
from protocol.frame import decode_request
from tests.support.line.lies import lying_bench
from tests.support.line.sim_line import INSTANT_S, FakeClock, Rig, SimulatedLine, watched

GAP_S = 0.5
"""While the cable is in nobody's hands: longer than a silence that is noticed, shorter than one that is asked about."""
_FIRST: Mapping[str, Any] = {"uptime": 60, "noise": 0, "boots": 37, "rate": 10, "history": 3, "seed": 1}
_SECOND: Mapping[str, Any] = {"uptime": 60, "noise": 0, "rate": 10, "history": 5, "seed": 2}
_SETTINGS = {"attitude_threshold": 85, "light_threshold": 70, "freefall_acceleration": 4, "freefall_time": 60}


class ExchangedLine(SimulatedLine):
    """From the frame numbered `at`, which is lost, it leads to `second`."""

    def __init__(self, clock: FakeClock, first: SimulatedBench, second: SimulatedBench) -> None:
        super().__init__(clock, bench=first)
        self.second, self.at = second, 0
        self.to_second: list[Request] = []
        """What was not a query, and not for the stream."""
        self._silent_until = 0.0

    @property
    def is_exchanged(self) -> bool:
        return self.bench is self.second

    def write(self, data: bytes) -> None:
        for start in range(0, len(data), 6):
            self.at -= 1
            if self.at == 0:
                self.second.wire.host_baud, self.bench = self.baud_rate, self.second
                self._silent_until = self.clock.now_s + GAP_S
            if self.clock.now_s < self._silent_until:
                continue
            request = decode_request(data[start : start + 6])
            if self.is_exchanged and request.hazard is not Hazard.NONE and request.command.name != "serial_output":
                self.to_second.append(request)
            super().write(data[start : start + 6])

    def read(self, longest_s: float, gather_s: float) -> bytes:
        if self.clock.now_s < self._silent_until:
            longest_s = min(longest_s, self._silent_until - self.clock.now_s + INSTANT_S)
        return super().read(longest_s, gather_s)


class ExchangedRig(Rig):
    """A session of the window on a module without a name; another one with `boots` follows at the frame `at`."""

    line: ExchangedLine

    def __init__(self, at: int, *, boots: int = 90) -> None:
        self.clock = FakeClock()
        first, second = lying_bench(_FIRST, self.clock), lying_bench({**_SECOND, "boots": boots}, self.clock)
        for name, value in _SETTINGS.items():
            setattr(second.module.memory, name, value)
        self.line = ExchangedLine(self.clock, first, second)
        self.session = Session(self.line, self.clock, is_attended=True)
        self.clock.now_s += INSTANT_S
        watched(self)
        self.step_for(3.0)
        self.line.at = at
