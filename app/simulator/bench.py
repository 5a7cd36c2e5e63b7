"""Simulated module with its physics, power and line; thread-safe, found by name.

Within a process a name always leads to the same module, also after it was unplugged and plugged in again.
"""

import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from app.simulator.answers import SimulatedModule
from app.simulator.memory import Memory, invent_records
from app.simulator.physics import Physics
from app.simulator.setup import Setup
from app.simulator.wire import Wire
from protocol.catalogue import BAUD
from protocol.messages import Source

DEFAULT_NAME = "module"
Clock = Callable[[], float]


@dataclass(frozen=True, slots=True, kw_only=True)
class BenchState:
    tilt_deg: float
    """Of the body, before zeroing and wobble."""
    is_falling: bool
    is_lifelike: bool
    bay_is_open: bool
    cell_v: float
    has_external_power: bool
    is_on: bool
    is_plugged_in: bool
    is_active: bool
    is_triggered: bool
    is_streaming: bool
    boot_count: int
    record_count: int
    baud_rate: int
    """Present rate of the module's line."""
    setup: Setup


class SimulatedBench:
    """All methods are thread-safe. `changed` is notified when something may have become due."""

    def __init__(
        self,
        setup: Setup | None = None,
        *,
        clock: Clock = time.monotonic,
        kind: type[SimulatedModule] = SimulatedModule,
    ) -> None:
        setup = setup or Setup()
        self.changed = threading.Condition(threading.RLock())
        self.clock = clock
        self.world = Physics(
            tilt_deg=setup.tilt, bay_is_open=setup.bay_open, has_external_power=setup.charger, cell_v=setup.cell,
            noise=setup.noise, is_lifelike=setup.lifelike, seed=setup.seed,
        )  # fmt: skip
        # Powering on counts one boot; the option is what is read afterwards.
        memory = Memory(boot_count=setup.boots, baud_code=BAUD.encode(setup.baud))
        invent_records(memory, setup.history, seed=setup.seed)
        memory.boot_count = (setup.boots - 1) & 0xFF
        self.module = kind(self.world, setup, memory=memory)
        self.wire = Wire(self.module)
        self.plug_number = 1
        """How often it was plugged in; a port that was opened under an earlier number is dead."""
        self.last_options: Mapping[str, Any] = {}
        """Those of the last URL that was opened, by option name."""
        self.is_plugged_in = True
        self._holder: object | None = None
        now_s = clock()
        self.module.power_on(now_s - setup.uptime)
        if setup.pwm_after:
            self.module.pwm_at_s = now_s + setup.pwm_after
        if setup.active:
            self.module.activate(is_active=True)
        if setup.uptime:
            self.wire.clear(now_s)

    # The body

    def set_tilt(self, tilt_deg: float) -> None:
        """Lay it at this angle, -180 … 180."""
        with self._act():
            self.world.tilt_deg = tilt_deg

    def drop(self, height_m: float) -> None:
        with self._act() as now_s:
            self.world.drop(height_m, now_s)

    def set_bay(self, *, is_open: bool) -> None:
        with self._act():
            self.world.bay_is_open = is_open

    def set_cell(self, cell_v: float) -> None:
        with self._act():
            self.world.cell_v = cell_v

    def set_charger(self, *, is_plugged_in: bool) -> None:
        """Connect external power, which wakes a module that was shut down, or disconnect it."""
        with self._act() as now_s:
            self.module.set_charger(now_s, is_plugged_in=is_plugged_in)

    def set_lifelike(self, *, is_lifelike: bool) -> None:
        with self._act():
            self.world.is_lifelike = is_lifelike

    def pulse_pwm(self) -> bool:
        """Trigger it by its PWM input; returns whether it fires."""
        with self._act() as now_s:
            return self.module.fire(Source.PWM, now_s)

    # Power and plug

    def restart(self) -> None:
        with self._act() as now_s:
            self.module.restart(now_s)

    def power_off(self) -> None:
        with self._act():
            self.module.power_off()

    def press_switch(self) -> None:
        with self._act() as now_s:
            self.module.press_switch(now_s)

    def unplug(self) -> None:
        with self._act() as now_s:
            self.wire.clear(now_s)
            self.is_plugged_in = False
            self._holder = None

    def plug(self) -> None:
        """Plug the serial adapter in again; ports that were open stay dead."""
        with self._act() as now_s:
            if not self.is_plugged_in:
                self.wire.clear(now_s)
                self.is_plugged_in = True
                self.plug_number += 1

    # Faults

    def change(self, **values: Any) -> None:
        """Set faults and `rate`, by option name."""
        with self._act():
            self.module.change(**values)

    def state(self) -> BenchState:
        with self._act() as now_s:
            module, world = self.module, self.world
            return BenchState(
                tilt_deg=world.tilt_deg, is_falling=world.is_falling(now_s),
                is_lifelike=world.is_lifelike, bay_is_open=world.bay_is_open,
                cell_v=world.cell_v, has_external_power=world.has_external_power, is_on=module.is_on,
                is_plugged_in=self.is_plugged_in, is_active=module.state.is_active, is_triggered=module.is_triggered,
                is_streaming=module.is_streaming, boot_count=module.memory.boot_count,
                record_count=len(module.memory.records), baud_rate=module.baud_rate, setup=module.setup,
            )  # fmt: skip

    # Its port

    def hold(self, holder: object) -> bool:
        """Claim the port exclusively; False if it is taken."""
        with self.changed:
            if self._holder is not None and self._holder is not holder:
                return False
            self._holder = holder
            return True

    def release(self, holder: object) -> None:
        with self.changed:
            if self._holder is holder:
                self._holder = None
                self.wire.host_baud = None
            self.changed.notify_all()

    @contextmanager
    def _act(self) -> Iterator[float]:
        """Holds the lock, advances the module to the present, and wakes threads that wait for bytes at the end."""
        with self.changed:
            now_s = self.clock()
            self.module.advance(now_s)
            try:
                yield now_s
            finally:
                self.changed.notify_all()


_benches: dict[str, SimulatedBench] = {}
_benches_lock = threading.Lock()


def module(name: str = DEFAULT_NAME, options: Mapping[str, Any] | None = None) -> SimulatedBench:
    """The module of this name, which is made on first use.

    `options` are parsed values by option name. A module that exists takes over faults and the rate if they differ from
    the last ones: opening the same URL again does not undo later changes. Its other state is kept.
    """
    options = dict(options or {})
    with _benches_lock:
        bench = _benches.get(name)
        if bench is None:
            bench = _benches[name] = SimulatedBench(Setup(**options))
            bench.last_options = options
            return bench
        is_news = options not in ({}, bench.last_options)
        if is_news:
            bench.last_options = options
    if is_news:
        bench.change(**options)
    return bench


def remove_bench(name: str = DEFAULT_NAME) -> None:
    """Delete the module of this name; its open port is dead then."""
    with _benches_lock:
        bench = _benches.pop(name, None)
    if bench is not None:
        bench.unplug()
