"""A line in virtual time to independent modules: the plug is moved, and what goes over it is lost, late and garbled."""

import heapq
import itertools
import math
import random
from collections.abc import Callable
from dataclasses import dataclass

from app.engine.procedure import Procedure
from app.engine.session import Session
from app.engine.transport import PortError
from protocol.events import Event
from tests.module.log import SENT
from tests.module.module import Module
from tests.module.options import Options
from tests.support.line.sim_line import FINEST_S, INSTANT_S, AnyRig, FakeClock, VirtualLine

BYTE_S = 10 / 115200
FRAME_BYTES = 6


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
    is_echoing: bool = False  # what the host sends comes back to it
    is_half_duplex: bool = False  # what the host sends while the module sends is lost
    has_second_reader: bool = False  # another program takes every other byte
    # Shares of the bytes of each direction that are lost, and in which a bit is turned.
    lost_bytes: float = 0.0
    turned_bytes: float = 0.0
    noise_every_s: float = 0.0  # bytes that are no frames come so often


class ModuleLine(VirtualLine):
    """A `Line`. All `modules` are at its other end; one at another rate hears and says garbage."""

    def __init__(
        self, clock: FakeClock, *modules: Module, wear: Wear | None = None, seed: int = 1, baud_rate: int = 115200,
        port: str = "",
    ) -> None:  # fmt: skip
        self.port, self.clock, self.modules, self.wear, self.baud_rate = port, clock, modules, wear or Wear(), baud_rate
        self.opened_at = clock()
        self.sent: list[bytes] = []  # every frame of the host
        # Called with each frame of the host: before it is on its way, and when a module has taken it.
        self.on_frame: Callable[[bytes], None] = lambda _frame: None
        self.on_heard: Callable[[bytes], None] = lambda _frame: None
        self.error: PortError | None = None  # where it is set, the port fails for good
        # The next frames of the host are lost, and the next frame of the module is changed.
        self.loses_requests = 0
        self.change_next: Callable[[bytes], bytes] | None = None
        self._random = random.Random(seed)
        self._numbers = itertools.count()
        self._coming: list[tuple[float, int, bytes]] = []
        self._going: list[tuple[float, int, bytes]] = []
        self._planned: list[tuple[float, int, Callable[[], object]]] = []
        self._plugged_at = self._arrived_at = self._noisy_at = -math.inf
        self._up_free_at = self._down_free_at = -math.inf  # when each direction is free again

    def plan(self, after_s: float, act: Callable[[], object]) -> None:
        """Do this after a while."""
        heapq.heappush(self._planned, (self.clock.now_s + after_s, next(self._numbers), act))

    def move(self, module: Module, silent_s: float, *, is_announced: bool) -> None:
        """Pull the plug out, and put it into `module` after a while. `is_announced`: that one starts then, else it has
        been running all the time."""
        self._coming.clear()
        self._going.clear()
        self.modules = (module,)
        self._plugged_at = self.clock.now_s + silent_s
        if is_announced:
            self.plan(silent_s, lambda: module.restart(self.clock.now_s, off_s=0.0))
        self._pass_time()

    def inject(self, data: bytes, after_s: float = 0.0) -> None:
        """Deliver bytes that the module did not send."""
        self._arrive(self.clock.now_s + after_s, data)

    # As the session uses it

    def read(self, longest_s: float, _gather_s: float) -> bytes:
        end_s = self.clock.now_s + longest_s
        while True:
            self._check()
            self._pass_time()
            data = b""
            while self._coming and self._coming[0][0] <= self.clock.now_s:
                data += heapq.heappop(self._coming)[2]
            if data or self.clock.now_s >= end_s:
                return data[::2] if self.wear.has_second_reader else data
            times = [module.next_at() for module in self.modules]
            if self.wear.noise_every_s:
                times.append(self._noisy_at + self.wear.noise_every_s)
            times += [queue[0][0] for queue in (self._coming, self._going, self._planned) if queue]
            if self.clock.now_s < self._plugged_at:
                times.append(self._plugged_at)
            self.clock.now_s = min(end_s, max(self.clock.now_s + FINEST_S, min(times, default=end_s)))

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
            is_plugged = self.clock.now_s >= self._plugged_at
            if self.loses_requests:
                self.loses_requests -= 1
            elif is_plugged and not is_jammed and self._random.random() >= self.wear.loss:
                heapq.heappush(self._going, (self._up_free_at, next(self._numbers), frame))

    def use_rate(self, baud_rate: int) -> None:
        self._check()
        self.baud_rate = baud_rate
        self._coming.clear()

    # Time

    def _check(self) -> None:
        if self.error is not None:
            raise self.error

    def _pass_time(self) -> None:
        now = self.clock.now_s
        while self._planned and self._planned[0][0] <= now:
            heapq.heappop(self._planned)[2]()
        if self.wear.noise_every_s and now - self._noisy_at >= self.wear.noise_every_s:
            self._noisy_at = now
            self._arrive(now, bytes(self._random.choices(range(0x20, 0x41), k=100)))
        if now < self._plugged_at:
            for module in self.modules:
                module.speak(now)  # nobody hears it
            return
        if self._plugged_at > -math.inf:
            for module in self.modules:
                module.speak(self._plugged_at)
            self._plugged_at = -math.inf
        while self._going and self._going[0][0] <= now:
            at, _, frame = heapq.heappop(self._going)
            self._carry(at)
            for module in self.modules:
                module.hear(self._garbled(frame, module), at)
            self.on_heard(frame)
        self._carry(now)

    def _carry(self, now: float) -> None:
        """Put what the modules say until `now` on its way."""
        for module in self.modules:
            before = len(module.log)
            worn = module.speak(now)
            said = [entry for entry in module.log[before:] if entry.kind == SENT]
            if module.options.lose:  # as its own line leaves it
                self._send_down(worn, now)
            else:
                for entry in said:
                    self._send_down(self._garbled(entry.frame, module), now)

    def _garbled(self, frame: bytes, module: Module) -> bytes:
        if self.baud_rate != module.rate:
            return self._random.randbytes(len(frame))
        dice, wear = self._random, self.wear
        if not wear.lost_bytes and not wear.turned_bytes:
            return frame
        left = [byte for byte in frame if dice.random() >= wear.lost_bytes]
        return bytes(byte ^ (1 << dice.randrange(8) if dice.random() < wear.turned_bytes else 0) for byte in left)

    def _send_down(self, frame: bytes, now: float) -> None:
        wear, dice = self.wear, self._random
        self._down_free_at = max(now, self._down_free_at) + len(frame) * BYTE_S
        if not frame or dice.random() < wear.loss:
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


class ModuleRig(AnyRig):
    """A session on such a line. `reopen` is the next command on it."""

    def __init__(
        self,
        *options: Options,
        modules: tuple[Module, ...] = (),
        clock: FakeClock | None = None,
        wear: Wear | None = None,
        background: Callable[[], Procedure[None]] | None = None,
        seed: int = 1,
    ) -> None:
        """`modules`: by default one for each of the options, or one honest one."""
        self.clock = clock or FakeClock()
        self.modules = modules or tuple(
            Module(each, name=f"{number}", seed=number + 1, now=self.clock.now_s)
            for number, each in enumerate(options or (Options(),))
        )
        self.module = self.modules[0]
        self.wear, self.background, self.seed = wear, background, seed
        self.events: list[Event] = []
        self.reopen()

    def reopen(self) -> None:
        self.line = ModuleLine(self.clock, *self.modules, wear=self.wear, seed=self.seed)
        self.session = Session(self.line, self.clock, background=self.background)
        self.clock.now_s += INSTANT_S

    def step(self, longest_s: float) -> None:
        super().step(longest_s)
        self.events += self.session.events
        self.session.events.clear()
