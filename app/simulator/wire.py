"""Line between host and simulated module: speed, loss, corruption, lag.

The same seed and the same traffic give the same faults. Times are seconds of the module's clock.
"""

import math
import random
from collections import deque
from typing import NamedTuple

from app.simulator.answers import SimulatedModule
from app.simulator.hardware import BITS_PER_BYTE, SentBytes
from protocol.frame import HOST_FRAME_LENGTH

PART_S = 0.005
"""Longer bursts arrive in parts of this duration, as from an adapter."""
MAX_BYTES = 65536
"""Size of the driver's receive buffer."""


class Burst(NamedTuple):
    begins_s: float
    data: bytes
    byte_s: float
    """Time of one byte."""

    @property
    def ends_s(self) -> float:
        return self.begins_s + len(self.data) * self.byte_s


class Wire:
    """Both directions of the line to a module. `host_baud` None: the host's rate always fits (TCP)."""

    def __init__(self, module: SimulatedModule, *, host_baud: int | None = None) -> None:
        self.module = module
        self.host_baud = host_baud
        self._up: deque[Burst] = deque()
        self._down: deque[Burst] = deque()
        self._up_free_s = -math.inf
        self._down_free_s = -math.inf
        self._up_random = random.Random(module.setup.seed)  # noqa: S311 (faults, not secrets)
        self._down_random = random.Random(module.setup.seed + 1)  # noqa: S311

    def write(self, data: bytes, now_s: float) -> None:
        byte_s = BITS_PER_BYTE / (self.host_baud or self.module.baud_rate)
        begins_s = max(now_s, self._up_free_s)
        self._up_free_s = begins_s + len(data) * byte_s
        for at in range(0, len(data), HOST_FRAME_LENGTH):
            self._up.append(Burst(begins_s + at * byte_s, data[at : at + HOST_FRAME_LENGTH], byte_s))

    def read(self, now_s: float) -> bytes:
        """What has arrived at the host since the last call."""
        self._pump(now_s)
        arrived = bytearray()
        while self._down and self._down[0].begins_s <= now_s:
            burst = self._down[0]
            if burst.ends_s <= now_s:
                arrived += burst.data
                self._down.popleft()
                continue
            count = int((now_s - burst.begins_s) / burst.byte_s)
            if count:
                arrived += burst.data[:count]
                self._down[0] = Burst(burst.begins_s + count * burst.byte_s, burst.data[count:], burst.byte_s)
            break
        return bytes(arrived[-MAX_BYTES:])

    def next_due(self, now_s: float) -> float | None:
        """When a burst or a part of one arrives, or the module has something to do; None for never."""
        due_s = self.module.next_due(now_s)
        times_s = [] if due_s is None else [due_s]
        if self._up:
            times_s.append(self._up[0].ends_s)
        if self._down:
            burst = self._down[0]
            times_s.append(min(burst.ends_s, burst.begins_s + PART_S))
        return max(now_s, min(times_s)) if times_s else None

    def clear(self, now_s: float) -> None:
        """Discard all bytes in transit: the adapter was unplugged, or the port is being opened."""
        self._pump(now_s)
        self._up.clear()
        self._down.clear()
        self._up_free_s = self._down_free_s = -math.inf

    def _pump(self, now_s: float) -> None:
        while self._up and self._up[0].ends_s <= now_s:
            burst = self._up.popleft()
            self._send_down(self.module.collect(burst.ends_s))
            data = burst.data
            if self.host_baud is not None and self.host_baud != self.module.baud_rate:
                data = _garble(data, self.host_baud, self.module.baud_rate, self._up_random)
            self._send_down(self.module.receive(data, burst.ends_s))
        self._send_down(self.module.collect(now_s))

    def _send_down(self, bursts: list[SentBytes]) -> None:
        for sent in bursts:
            byte_s = BITS_PER_BYTE / sent.baud_rate
            data = sent.data
            if self.host_baud is not None and self.host_baud != sent.baud_rate:
                data = _garble(data, sent.baud_rate, self.host_baud, self._down_random)
                byte_s *= len(sent.data) / len(data)  # in the time that sending took
            if not self.module.setup.mute:
                self._suffer(Burst(sent.at_s, data, byte_s))

    def _suffer(self, burst: Burst) -> None:
        """Lose a burst, or deliver it with bits turned."""
        faults = self.module.setup
        source = self._down_random
        if faults.drop and source.random() < faults.drop:
            return
        data = burst.data
        if faults.corrupt:
            data = bytes(
                byte ^ (1 << source.randrange(8)) if source.random() < faults.corrupt else byte for byte in data
            )
        self._deliver(burst._replace(begins_s=max(burst.begins_s, self._down_free_s), data=data))

    def _deliver(self, burst: Burst) -> None:
        """The burst leaves the line at its time, and reaches the host after the lag."""
        self._down_free_s = burst.ends_s
        self._down.append(burst._replace(begins_s=burst.begins_s + self.module.setup.lag_ms / 1000))


def _garble(data: bytes, sent_baud: int, read_baud: int, source: random.Random) -> bytes:
    """What a receiver at another rate reads: as many random bytes as fit into the time."""
    return source.randbytes(max(1, min(4 * len(data), len(data) * read_baud // max(1, sent_baud))))
