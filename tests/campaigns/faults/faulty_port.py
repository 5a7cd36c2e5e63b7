"""A serial port on the simulated module and a fake clock that goes wrong at one chosen moment of one chosen request.

It stands below `SerialLine`, in pyserial's place: so what pyserial throws is turned into ours by the real transport.
"""

import itertools
import random
from collections import deque
from collections.abc import Callable
from enum import Enum
from typing import NamedTuple

from app.simulator.bench import SimulatedBench
from protocol.catalogue import Request
from protocol.frame import HOST_FRAME_LENGTH, decode_request
from tests.support.line.sim_line import FakeClock

FINEST_S = 1e-4
READ_SLICE_S = 0.01


class Phase(Enum):
    """When a fault happens."""

    BEFORE = "before the request"
    IN_REQUEST = "in the middle of it"
    BEFORE_REPLY = "before the reply"
    IN_REPLY = "during the reply"
    AFTER = "after the reply"


class Arrival(NamedTuple):
    at_s: float
    data: bytes


Shape = Callable[[bytes, float], list[Arrival]]


def as_it_comes(data: bytes, now_s: float) -> list[Arrival]:
    return [Arrival(now_s, data)]


class FakePort:
    """The part of `serial.Serial` that `SerialLine` uses; calls `strike` once, at `phase` of request `index`."""

    def __init__(self, bench: SimulatedBench, clock: FakeClock, *, baud_rate: int = 115200) -> None:
        self.bench = bench
        self.clock = clock
        self.is_closed = False
        self.timeout = READ_SLICE_S
        self.requests: list[Request] = []
        self.random = random.Random(7)
        self.strike: Callable[[], None] = lambda: None
        self.phase = Phase.BEFORE
        self.index = -1
        self.has_struck = False
        self.has_raised = False
        # What a fault changes
        self.read_fails: Callable[[], Exception] | None = None
        self.waiting_fails: Callable[[], Exception] | None = None
        self.write_fails: Callable[[], Exception] | None = None
        self.reset_fails: Callable[[], Exception] | None = None
        self.write_takes_s = 0.0
        self.shape: Shape = as_it_comes
        self.loses_requests = 0
        self._baudrate = baud_rate
        self._arrivals: deque[Arrival] = deque()
        self._ready = bytearray()
        self._written = 0
        self._came_since = 0
        bench.wire.host_baud = baud_rate

    # What SerialLine calls

    @property
    def baudrate(self) -> int:
        return self._baudrate

    @baudrate.setter
    def baudrate(self, baud_rate: int) -> None:
        self._raise(self.reset_fails)
        if baud_rate != self._baudrate:
            # What is still on its way was sent at the old rate.
            self._arrivals = deque(
                Arrival(arrival.at_s, self.random.randbytes(len(arrival.data)))
                for arrival in self._arrivals
                if arrival.data
            )
        self._baudrate = self.bench.wire.host_baud = baud_rate

    @property
    def in_waiting(self) -> int:
        self._raise(self.waiting_fails)
        self._pump()
        return len(self._ready)

    def read(self, size: int = 1) -> bytes:
        self._raise(self.read_fails)
        end_s = self.clock.now_s + READ_SLICE_S
        while True:
            self._pump()
            if self._ready:
                break
            due_s = self._next_due()
            if due_s is None or due_s > end_s:
                self.clock.now_s = max(self.clock.now_s, end_s)
                self._pump()
                break
            self.clock.now_s = max(due_s, self.clock.now_s + FINEST_S)
            self._raise(self.read_fails)
        if self._is_in_reply():
            # The first half of the reply goes up, then the fault strikes; what it leaves of the rest comes after it.
            half = bytes(self._ready[: self._reply_half()])
            rest = bytes(self._ready[len(half) :])
            self._ready.clear()
            self._arrivals.appendleft(Arrival(self.clock.now_s, rest))
            self._came_since += len(half)
            self._strike()
            return half
        taken = bytes(self._ready[:size])
        del self._ready[:size]
        self._came_since += len(taken)
        return taken

    def write(self, data: bytes) -> int:
        for at in range(0, len(data), HOST_FRAME_LENGTH):
            self._write(data[at : at + HOST_FRAME_LENGTH])
        return len(data)

    def reset_input_buffer(self) -> None:
        self._raise(self.reset_fails)
        self._pump()
        self._ready.clear()

    def reset_output_buffer(self) -> None:
        self._raise(self.reset_fails)

    def close(self) -> None:
        self.is_closed = True
        if self.reset_fails is not None:
            raise self.reset_fails()

    # What faults call

    def inject(self, data: bytes, *, after_s: float = 0.0) -> None:
        """Deliver bytes that the module did not send."""
        self._arrivals.append(Arrival(self.clock.now_s + after_s, data))

    def drop_pending(self) -> None:
        """Discard all bytes on their way to the host."""
        self._arrivals.clear()
        self._ready.clear()

    def mangle_pending(self, change: Callable[[bytes], bytes]) -> bool:
        """Change the bytes on their way; return False if there are none."""
        if not self._arrivals or not self._arrivals[0].data:
            return False
        first = self._arrivals.popleft()
        self._arrivals.appendleft(Arrival(first.at_s, change(first.data)))
        return True

    def strike_if_idle(self) -> None:
        """Called between two steps, when no reply is pending."""
        if self.has_struck:
            return
        is_start = self.phase is Phase.BEFORE and self.index == 0 and not self.requests
        is_over = self.phase is Phase.AFTER and self._written > self.index and self._came_since >= self._reply_length()
        if is_start or is_over:
            self._strike()

    # Within

    def _raise(self, make: Callable[[], Exception] | None) -> None:
        if make is not None:
            self.has_raised = True
            raise make()

    def _strike(self) -> None:
        self.has_struck = True
        self.strike()

    def _write(self, frame: bytes) -> None:
        is_target = not self.has_struck and self._written == self.index
        is_next = not self.has_struck and self._written == self.index + 1
        if (is_target and self.phase is Phase.BEFORE) or (is_next and self.phase is Phase.AFTER):
            self._strike()
        self._fail_write()
        half = HOST_FRAME_LENGTH // 2
        if is_target and self.phase is Phase.IN_REQUEST:
            self.bench.wire.write(frame[:half], self.clock.now_s)
            self._strike()
            self.requests.append(decode_request(frame))
            self._written += 1
            self._came_since = 0
            self._fail_write()
            self._put(frame[half:])
            return
        self.requests.append(decode_request(frame))
        self._written += 1
        if is_target or not self.has_struck:
            self._came_since = 0
        self._put(frame)
        if is_target and self.phase is Phase.BEFORE_REPLY:
            self._strike()

    def _fail_write(self) -> None:
        if self.write_fails is not None:
            self.clock.now_s += self.write_takes_s
            self._raise(self.write_fails)

    def _put(self, data: bytes) -> None:
        if self.loses_requests:
            self.loses_requests -= 1
        else:
            self.bench.wire.write(data, self.clock.now_s)

    def _pump(self) -> None:
        now_s = self.clock.now_s
        data = self.bench.wire.read(now_s)
        if data:
            self._arrivals.extend(self.shape(data, now_s))
        while self._arrivals and self._arrivals[0].at_s <= now_s:
            self._ready += self._arrivals.popleft().data

    def _next_due(self) -> float | None:
        dues = [self.bench.wire.next_due(self.clock.now_s)]
        if self._arrivals:
            dues.append(self._arrivals[0].at_s)
        return min((due for due in dues if due is not None), default=None)

    def _reply_length(self) -> int:
        if self._written <= self.index or self.index >= len(self.requests):
            return 1 << 30
        return self.requests[self.index].command.layout.value

    def _reply_half(self) -> int:
        return max(1, min(len(self._ready) - 1, self._reply_length() // 2))

    def _is_in_reply(self) -> bool:
        is_waiting = not self.has_struck and self.phase is Phase.IN_REPLY and self._written == self.index + 1
        return is_waiting and bool(self._ready)


def spread(data: bytes, now_s: float, pause_s: float) -> list[Arrival]:
    """Deliver bytes one by one, with a pause between them."""
    return [Arrival(now_s + number * pause_s, bytes((byte,))) for number, byte in enumerate(data)]


def one_shot(port: FakePort, change: Callable[[bytes], bytes]) -> None:
    """Change the next bytes once."""
    if port.mangle_pending(change):
        return
    before = port.shape

    def shape(data: bytes, now_s: float) -> list[Arrival]:
        port.shape = before
        return before(change(data), now_s)

    port.shape = shape


def every_other(data: bytes, counter: "itertools.count[int]") -> bytes:
    """Return the bytes that remain when another reader takes every second one."""
    return bytes(byte for byte in data if next(counter) % 2 == 0)
