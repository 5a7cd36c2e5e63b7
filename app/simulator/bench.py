"""A simulated module with its world, its line and its plug; found by its name.

Within a process a name always leads to the same module, also after it was unplugged and plugged in again. Times are
seconds of the module's clock.
"""

import math
import random
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from msgspec.structs import replace

from app.simulator.module import BITS_PER_BYTE, Memory, Physics, SimulatedModule
from app.simulator.setup import Setup
from protocol.catalogue import BAUD
from protocol.messages import Source

FALL_M = 30.0  # the height of the fall that an option asks for


class Wire:
    """The line between a host and the module, in both directions: its speed, what it loses and disturbs, and how late
    it is. `host_baud` is the host's rate, None where it always fits, as over TCP.

    The same seed and the same traffic give the same faults. A frame arrives whole, when its last bit does.
    """

    def __init__(self, module: SimulatedModule) -> None:
        self.module = module
        self.host_baud: int | None = None
        # What is on its way to the module, with the time at which it arrives.
        self._to_module: deque[tuple[float, bytes]] = deque()
        self._free_s = -math.inf
        self._dice = random.Random(module.setup.seed)  # noqa: S311 (faults, not secrets)

    def write(self, data: bytes, now_s: float) -> None:
        byte_s = BITS_PER_BYTE / (self.host_baud or self.module.baud_rate)
        self._free_s = max(now_s, self._free_s) + len(data) * byte_s
        self._to_module.append((self._free_s, data))

    def read(self, now_s: float) -> bytes:
        while self._to_module and self._to_module[0][0] <= now_s:
            at_s, data = self._to_module.popleft()
            self.module.receive(self._received(data, self.host_baud, self.module.baud_rate), at_s)
        self.module.advance(now_s)
        faults, dice, arrived = self.module.setup, self._dice, bytearray()
        while self.module.out and self.module.out[0].ends_s + faults.lag_ms / 1000 <= now_s:
            sent = self.module.out.popleft()
            if faults.mute or dice.random() < faults.drop:
                continue
            data = self._received(sent.data, sent.baud_rate, self.host_baud)
            if faults.corrupt:
                masks = (1 << dice.randrange(8) if dice.random() < faults.corrupt else 0 for _ in data)
                data = bytes(byte ^ mask for byte, mask in zip(data, masks, strict=True))
            arrived += data
        return bytes(arrived)

    def next_due(self, now_s: float) -> float:
        """Return when something is to be read, or happens to the module; infinity for never."""
        dues_s = [self.module.due_s]
        if self._to_module:
            dues_s.append(self._to_module[0][0])
        if self.module.out:
            dues_s.append(self.module.out[0].ends_s + self.module.setup.lag_ms / 1000)
        return max(now_s, min(dues_s))

    def clear(self, now_s: float) -> None:
        """Discard all that is on its way: the adapter was unplugged, or the port is being opened."""
        self.read(now_s)
        self._to_module.clear()
        self.module.out.clear()
        self._free_s = -math.inf

    def _received(self, data: bytes, sent_baud: int | None, read_baud: int | None) -> bytes:
        """Return what a receiver at this rate makes of it: at another one as many wrong bytes as fit into the time."""
        if sent_baud is None or read_baud is None or sent_baud == read_baud:
            return data
        count = len(data) * read_baud // max(1, sent_baud)
        return self._dice.randbytes(max(1, min(4 * len(data), count)))


class SimulatedBench:
    """A simulated module with its port and its world. All methods are thread-safe; whoever uses its parts holds
    `lock`."""

    def __init__(self, setup: Setup | None = None, *, clock: Callable[[], float] = time.monotonic) -> None:
        setup = setup or Setup()
        self.lock = threading.RLock()
        self.clock = clock
        self.world = Physics(
            tilt_deg=setup.tilt,
            bay_is_open=setup.bay_open,
            has_external_power=setup.charger,
            cell_v=setup.cell,
            is_lifelike=setup.lifelike,
        )
        # Each time it is switched on counts one.
        before = (setup.boots - setup.history - 1) & 0xFF
        memory = Memory(boot_count=before, baud_code=BAUD.encode(setup.baud))
        self.module = SimulatedModule(self.world, setup, memory=memory)
        self.wire = Wire(self.module)
        self.is_plugged_in = True
        self.holder: object | None = None  # who has the port open; one that had it when it was unplugged is dead
        now_s, dice = clock(), random.Random(setup.seed)  # noqa: S311 (variety, not secrets)
        for _ in range(setup.history):
            self.module.world = Physics(cell_v=dice.choice((3.64, 3.9, 4.1)))
            self.module.power_on(now_s - dice.randrange(20, 5400))
            self.module.activate(is_active=True)
            self.module.fire(dice.choice((Source.ATTITUDE, Source.FREEFALL, Source.PWM)), now_s)
        self.module.world = self.world
        self.module.power_off()
        self.wire.clear(now_s)
        self.module.power_on(now_s - setup.uptime)
        if setup.uptime:
            self.wire.clear(now_s)
        if setup.active:
            self.module.activate(is_active=True)
        if setup.pwm_after:
            self.module.plan(now_s + setup.pwm_after, lambda at_s: self.module.fire(Source.PWM, at_s))
        if setup.fall_after:
            self.module.plan(now_s + setup.fall_after, lambda at_s: self.world.drop(FALL_M, at_s))
        if setup.restart_after:
            self.module.plan(now_s + setup.restart_after, self.module.power_on)

    @contextmanager
    def at_present(self) -> Iterator[float]:
        with self.lock:
            now_s = self.clock()
            self.module.advance(now_s)
            yield now_s

    # The body

    def set_world(self, **values: Any) -> None:
        with self.at_present():
            for name, value in values.items():
                setattr(self.world, name, value)

    def drop(self, height_m: float) -> None:
        with self.at_present() as now_s:
            self.world.drop(height_m, now_s)

    def set_charger(self, *, is_plugged_in: bool) -> None:
        """Connect external power, which wakes it after a shutdown ("通过外接供电通电自醒开机"), or disconnect it."""
        with self.at_present() as now_s:
            self.world.has_external_power = is_plugged_in
            if is_plugged_in and not self.module.is_on:
                self.module.power_on(now_s)

    def pulse_pwm(self) -> bool:
        with self.at_present() as now_s:
            return self.module.fire(Source.PWM, now_s)

    # Power, plug and faults

    def restart(self) -> None:
        """Switch it off and on, or only on."""
        with self.at_present() as now_s:
            self.module.power_on(now_s)

    def unplug(self) -> None:
        with self.at_present() as now_s:
            self.wire.clear(now_s)
            self.is_plugged_in = False
            self.holder = None

    def plug(self) -> None:
        """Plug the serial adapter in again; ports that were open stay dead."""
        self.is_plugged_in = True

    def change(self, **values: Any) -> None:
        """Set options by name, of which the rate of the stream and the faults on the line count from now on."""
        with self.at_present():
            self.module.setup = replace(self.module.setup, **values)


_benches: dict[str, SimulatedBench] = {}


def module(name: str, setup: Setup | None = None) -> SimulatedBench:
    """Return the module of this name, which is made so where there is none; an existing one is as it is."""
    if name not in _benches:
        _benches.setdefault(name, SimulatedBench(setup))  # another thread may have made it meanwhile
    return _benches[name]


def remove_bench(name: str) -> None:
    bench = _benches.pop(name, None)
    if bench is not None:
        bench.unplug()
