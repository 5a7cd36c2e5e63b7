"""A plug in virtual time: it is moved from one module to the next, and its line loses, delays, repeats and garbles."""

import heapq
import itertools
import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from app.engine.conversation import ConversationView
from app.engine.procedure import Job, Procedure
from app.engine.session import Session
from app.engine.transport import PortError
from protocol.events import Event
from tests.module.log import SENT
from tests.module.module import Module
from tests.support.line.sim_line import FakeClock

BYTE_S = 10 / 115200
FRAME_BYTES = 6
FINEST_S = 1e-4
MAX_STEP_S = 0.05


@dataclass(frozen=True)
class Wear:
    """What a line does to frames. Shares are of the frames of each direction."""

    loss: float = 0.0
    # From the module to the host, constant, and up to so much more; the order stays.
    lag_s: float = 0.0
    jitter_s: float = 0.0
    # What the module says arrives at multiples of this, or a byte at a time with such pauses.
    blocks_s: float = 0.0
    byte_pause_s: float = 0.0
    # Of the module's frames: each comes again so much later, as with a bridge that repeats what it passes on.
    repeats: float = 0.0
    repeats_after_s: tuple[float, float] = (0.25, 0.8)
    # What the host sends comes back to it.
    is_echoing: bool = False
    # What the host sends while the module sends is lost.
    is_half_duplex: bool = False
    # Another program takes every other byte.
    has_second_reader: bool = False
    # Shares of the bytes of each direction that are lost, and in which a bit is turned.
    lost_bytes: float = 0.0
    turned_bytes: float = 0.0
    # Bytes that are no frames come every so often.
    noise_every_s: float = 0.0


class Plug:
    """A `Line` to the module in which the plug is. At another rate than the module's, each hears garbage."""

    sets_rate = True

    def __init__(self, clock: FakeClock, module: Module, wear: Wear | None = None, *, seed: int = 1) -> None:
        self.clock = clock
        self.module = module
        self.wear = wear or Wear()
        self.baud_rate = 115200
        self.sent: list[bytes] = []  # every frame of the host
        # Called with each frame of the host: before it is on its way, and when the module has taken it.
        self.on_frame: Callable[[bytes], None] = lambda _frame: None
        self.on_heard: Callable[[bytes], None] = lambda _frame: None
        # Where it is set, the port fails for good.
        self.error: PortError | None = None
        # The next frames of the host are lost, and the next frame of the module is changed.
        self.loses_requests = 0
        self.change_next: Callable[[bytes], bytes] | None = None
        self._random = random.Random(seed)
        self._numbers = itertools.count()
        self._coming: list[tuple[float, int, bytes]] = []
        self._going: list[tuple[float, int, bytes]] = []
        self._plugged_at = self._arrived_at = self._noisy_at = -math.inf
        self._is_announced = False
        # When each direction is free again.
        self._up_free_at = self._down_free_at = -math.inf

    def move(self, module: Module, silent_s: float, *, is_announced: bool) -> None:
        """Pull the plug out, and put it into `module` after a while. `is_announced`: that one starts then, else it has
        been running all the time."""
        self._coming.clear()
        self._going.clear()
        self.module = module
        self._plugged_at = self.clock.now_s + silent_s
        self._is_announced = is_announced
        self._pass_time()

    @property
    def is_plugged(self) -> bool:
        return self.clock.now_s >= self._plugged_at

    def inject(self, data: bytes, after_s: float = 0.0) -> None:
        """Deliver bytes that the module did not send."""
        self._arrive(self.clock.now_s + after_s, data)

    # As the session uses it

    def read(self, longest_s: float, _gather_s: float) -> bytes:
        end_s = self.clock.now_s + longest_s
        while True:
            self._check()
            self._pass_time()
            if self._coming and self._coming[0][0] <= self.clock.now_s:
                return self._take()
            if self.clock.now_s >= end_s:
                return b""
            self.clock.now_s = min(end_s, max(self.clock.now_s + FINEST_S, self._next_at()))

    def write(self, data: bytes) -> None:
        for at in range(0, len(data), FRAME_BYTES):
            frame = data[at : at + FRAME_BYTES]
            self.sent.append(frame)
            self.on_frame(frame)
            self._check()
            begins_at = max(self.clock.now_s, self._up_free_at)
            self._up_free_at = begins_at + len(frame) * BYTE_S
            if self.wear.is_echoing:
                self._arrive(self._up_free_at, frame)
            is_jammed = self.wear.is_half_duplex and begins_at < self._down_free_at
            if self.loses_requests:
                self.loses_requests -= 1
            elif self.is_plugged and not is_jammed and self._random.random() >= self.wear.loss:
                heapq.heappush(self._going, (self._up_free_at, next(self._numbers), self._garbled(frame)))

    def use_rate(self, baud_rate: int) -> None:
        self._check()
        self.baud_rate = baud_rate
        self._coming.clear()

    def close(self) -> None:
        """Has no effect: the next session may use it."""

    # Time

    def _check(self) -> None:
        if self.error is not None:
            raise self.error

    def _next_at(self) -> float:
        times = [self.module.next_at()]
        if not self.is_plugged:
            times.append(self._plugged_at)
        if self.wear.noise_every_s:
            times.append(self._noisy_at + self.wear.noise_every_s)
        times += [queue[0][0] for queue in (self._coming, self._going) if queue]
        return min(times)

    def _take(self) -> bytes:
        data = b""
        while self._coming and self._coming[0][0] <= self.clock.now_s:
            data += heapq.heappop(self._coming)[2]
        return data[::2] if self.wear.has_second_reader else data

    def _pass_time(self) -> None:
        now = self.clock.now_s
        if self.wear.noise_every_s and now - self._noisy_at >= self.wear.noise_every_s:
            self._noisy_at = now
            self._arrive(now, bytes(self._random.choices(range(0x20, 0x41), k=100)))
        if not self.is_plugged:
            self.module.speak(now)  # nobody hears it
            return
        if self._plugged_at > -math.inf:
            self.module.speak(self._plugged_at)
            if self._is_announced:
                self.module.restart(self._plugged_at, off_s=0.0)
            self._plugged_at, self._is_announced = -math.inf, False
        while self._going and self._going[0][0] <= now:
            at, _, frame = heapq.heappop(self._going)
            self._carry(at)
            self.module.hear(frame, at)
            self.on_heard(frame)
        self._carry(now)

    def _carry(self, now: float) -> None:
        """Put what the module says until `now` on its way."""
        log = self.module.log
        before = len(log)
        self.module.speak(now)
        for entry in log[before:]:
            if entry.kind == SENT:
                self._send_down(self._garbled(entry.frame), now)

    def _garbled(self, frame: bytes) -> bytes:
        if self.baud_rate != self.module.rate:
            return self._random.randbytes(len(frame))
        if not self.wear.lost_bytes and not self.wear.turned_bytes:
            return frame
        left = [byte for byte in frame if self._random.random() >= self.wear.lost_bytes]
        return bytes(self._turned(byte) for byte in left)

    def _turned(self, byte: int) -> int:
        return byte ^ 1 << self._random.randrange(8) if self._random.random() < self.wear.turned_bytes else byte

    def _send_down(self, frame: bytes, now: float) -> None:
        wear, dice = self.wear, self._random
        self._down_free_at = max(now, self._down_free_at) + len(frame) * BYTE_S
        if dice.random() < wear.loss:
            return
        if self.change_next is not None:
            frame, self.change_next = self.change_next(frame), None
        at = self._down_free_at + wear.lag_s + dice.uniform(0.0, wear.jitter_s)
        if wear.blocks_s:
            at = math.ceil(at / wear.blocks_s) * wear.blocks_s
        self._arrived_at = at = max(at, self._arrived_at)
        if wear.byte_pause_s:
            for number, byte in enumerate(frame):
                self._arrive(at + number * wear.byte_pause_s, bytes((byte,)))
            self._arrived_at = at + len(frame) * wear.byte_pause_s
        else:
            self._arrive(at, frame)
        if dice.random() < wear.repeats:
            self._arrive(at + dice.uniform(*wear.repeats_after_s), frame)

    def _arrive(self, at: float, data: bytes) -> None:
        heapq.heappush(self._coming, (at, next(self._numbers), data))


class PlugRig:
    """A session on a plug."""

    def __init__(
        self,
        module: Module,
        clock: FakeClock,
        wear: Wear | None = None,
        background: Callable[[], Procedure[None]] | None = None,
        *,
        seed: int = 1,
    ) -> None:
        self.clock = clock
        self.plug = Plug(clock, module, wear, seed=seed)
        self.session = Session(self.plug, clock, background=background)
        self.events: list[Event] = []
        self.on_step: Callable[[], None] = lambda: None
        self.clock.now_s += 1e-6

    @property
    def view(self) -> ConversationView:
        return self.session.conversation_view(self.clock.now_s)

    def step(self, longest_s: float = MAX_STEP_S) -> None:
        self.session.step(longest_s)
        self.events += self.session.take_events()
        self.session.take_samples()
        self.on_step()

    def step_for(self, seconds: float) -> None:
        end_s = self.clock.now_s + seconds
        while self.clock.now_s < end_s:
            self.step(min(MAX_STEP_S, end_s - self.clock.now_s))

    def begin(self) -> None:
        while not self.view.is_going:
            self.step()

    def start(self, procedure: Procedure[Any], *, is_urgent: bool = False, **more: Any) -> Job[Any]:
        job = Job(procedure, **more)
        self.session.run(job, is_urgent=is_urgent)
        return job
