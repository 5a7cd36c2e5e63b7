"""A simulated module with its world, its line and its plug; found by its name.

Within a process a name always leads to the same module, also after it was unplugged and plugged in again.
"""

import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from app.simulator.memory import Memory, invent_records
from app.simulator.module import SimulatedModule
from app.simulator.physics import Physics
from app.simulator.setup import Setup
from app.simulator.wire import Wire
from protocol.catalogue import BAUD
from protocol.messages import Source

DEFAULT_NAME = "module"
FALL_M = 30.0  # the height of the fall that an option asks for
Clock = Callable[[], float]


class SimulatedBench:
    """All methods are thread-safe. `changed` is notified where something may have become due."""

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
            tilt_deg=setup.tilt,
            bay_is_open=setup.bay_open,
            has_external_power=setup.charger,
            cell_v=setup.cell,
            is_lifelike=setup.lifelike,
        )
        memory = Memory(boot_count=setup.boots, baud_code=BAUD.encode(setup.baud))
        invent_records(memory, setup.history, seed=setup.seed)
        memory.boot_count = (setup.boots - 1) & 0xFF  # to switch it on counts one
        self.module = kind(self.world, setup, memory=memory)
        self.wire = Wire(self.module)
        self.is_plugged_in = True
        self.plug_number = 1  # how often it was plugged in; a port that was opened before is dead
        self.holder: object | None = None  # who has the port open
        now_s = clock()
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
            self.module.plan(now_s + setup.restart_after, self.module.restart)

    @contextmanager
    def at_present(self) -> Iterator[float]:
        """Hold the lock at the present time, which it yields, and wake who waits for bytes."""
        with self.changed:
            now_s = self.clock()
            self.module.advance(now_s)
            try:
                yield now_s
            finally:
                self.changed.notify_all()

    # The body

    def set_world(self, **values: Any) -> None:
        """Set fields of `Physics`: lay it at an angle, open the bay …"""
        with self.at_present():
            for name, value in values.items():
                setattr(self.world, name, value)

    def drop(self, height_m: float) -> None:
        with self.at_present() as now_s:
            self.world.drop(height_m, now_s)

    def set_charger(self, *, is_plugged_in: bool) -> None:
        """Connect external power, which wakes a module that was shut down, or disconnect it."""
        with self.at_present() as now_s:
            self.module.set_charger(now_s, is_plugged_in=is_plugged_in)

    def pulse_pwm(self) -> bool:
        """Trigger it by its PWM input; return whether it fires."""
        with self.at_present() as now_s:
            return self.module.fire(Source.PWM, now_s)

    # Power, plug and faults

    def restart(self) -> None:
        with self.at_present() as now_s:
            self.module.restart(now_s)

    def power_off(self) -> None:
        with self.at_present():
            self.module.power_off()

    def press_switch(self) -> None:
        with self.at_present() as now_s:
            self.module.press_switch(now_s)

    def unplug(self) -> None:
        with self.at_present() as now_s:
            self.wire.clear(now_s)
            self.is_plugged_in = False
            self.holder = None

    def plug(self) -> None:
        """Plug the serial adapter in again; ports that were open stay dead."""
        with self.at_present() as now_s:
            if not self.is_plugged_in:
                self.wire.clear(now_s)
                self.is_plugged_in = True
                self.plug_number += 1

    def change(self, **values: Any) -> None:
        """Set faults and `rate`, by option name."""
        with self.at_present():
            self.module.change(**values)


_benches: dict[str, SimulatedBench] = {}
_benches_lock = threading.Lock()


def module(name: str = DEFAULT_NAME, options: Mapping[str, Any] | None = None) -> SimulatedBench:
    """Return the module of this name, which is made where there is none.

    `options` are values by option name, of a new one; what an existing one is like was chosen before.
    """
    with _benches_lock:
        if name not in _benches:
            _benches[name] = SimulatedBench(Setup(**(options or {})))
        return _benches[name]


def remove_bench(name: str = DEFAULT_NAME) -> None:
    """Forget the module of this name; a port that is open is dead then."""
    with _benches_lock:
        bench = _benches.pop(name, None)
    if bench is not None:
        bench.unplug()
