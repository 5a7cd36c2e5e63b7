"""The line between a host and the simulated module: its speed, what it loses and disturbs, and how late it is.

The same seed and the same traffic give the same faults. Times are seconds of the module's clock. A frame arrives whole,
when its last bit does.
"""

import math
import random
from collections import deque

from app.simulator.module import BITS_PER_BYTE, SimulatedModule
from protocol.frame import HOST_FRAME_LENGTH

MAX_BYTES = 65536  # what the driver keeps for a host that does not read


class Wire:
    """Both directions. `host_baud` is the host's rate, None where it always fits, as over TCP."""

    def __init__(self, module: SimulatedModule, *, host_baud: int | None = None) -> None:
        self.module = module
        self.host_baud = host_baud
        # What is on its way, with the time at which it arrives, unless something before it is later.
        self._to_module: deque[tuple[float, bytes]] = deque()
        self._to_host: deque[tuple[float, bytes]] = deque()
        self._free_s = -math.inf
        self._random = random.Random(module.setup.seed)  # noqa: S311 (faults, not secrets)

    def write(self, data: bytes, now_s: float) -> None:
        """Send from the host; a burst behind another one waits until the line is free."""
        byte_s = BITS_PER_BYTE / (self.host_baud or self.module.baud_rate)
        self._free_s = max(now_s, self._free_s)
        for at in range(0, len(data), HOST_FRAME_LENGTH):
            frame = data[at : at + HOST_FRAME_LENGTH]
            self._free_s += len(frame) * byte_s
            self._to_module.append((self._free_s, frame))

    def read(self, now_s: float) -> bytes:
        """Return what has arrived at the host since the last call."""
        while self._to_module and self._to_module[0][0] <= now_s:
            at_s, data = self._to_module.popleft()
            self.module.receive(self._received(data, self.host_baud, self.module.baud_rate), at_s)
        self._collect(now_s)
        arrived = bytearray()
        while self._to_host and self._to_host[0][0] <= now_s:
            arrived += self._to_host.popleft()[1]
        return bytes(arrived[-MAX_BYTES:])

    def next_due(self, now_s: float) -> float | None:
        """Return when something arrives, or the module does something by itself; None for never."""
        dues_s = [queue[0][0] for queue in (self._to_module, self._to_host) if queue]
        module_s = self.module.next_due(now_s)
        if module_s is not None:
            dues_s.append(module_s)
        return max(now_s, min(dues_s)) if dues_s else None

    def clear(self, now_s: float) -> None:
        """Discard all that is on its way: the adapter was unplugged, or the port is being opened."""
        self.read(now_s)
        self._to_module.clear()
        self._to_host.clear()
        self._free_s = -math.inf

    def _collect(self, now_s: float) -> None:
        for sent in self.module.collect(now_s):
            if not self.module.setup.mute:
                self.suffer(self._received(sent.data, sent.baud_rate, self.host_baud), sent.ends_s)

    def suffer(self, data: bytes, at_s: float) -> None:
        """Lose a frame of the module, or bring it to the host with some bits turned."""
        faults = self.module.setup
        if self._random.random() < faults.drop:
            return
        if faults.corrupt:
            data = bytes(self._turned(byte) if self._random.random() < faults.corrupt else byte for byte in data)
        self.deliver(data, at_s)

    def deliver(self, data: bytes, at_s: float) -> None:
        """Bring it to the host after the lag; it overtakes nothing."""
        self._to_host.append((at_s + self.module.setup.lag_ms / 1000, data))

    def _turned(self, byte: int) -> int:
        return byte ^ (1 << self._random.randrange(8))

    def _received(self, data: bytes, sent_baud: int | None, read_baud: int | None) -> bytes:
        """Return what a receiver at this rate makes of it: at another one as many wrong bytes as fit into the time."""
        if sent_baud is None or read_baud is None or sent_baud == read_baud:
            return data
        count = len(data) * read_baud // max(1, sent_baud)
        return self._random.randbytes(max(1, min(4 * len(data), count)))
