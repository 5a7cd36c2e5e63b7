"""Simulated module with its physics, power and line; thread-safe, found by name.

The same name in one process is the same module: unplugged and plugged in again it is still what it was.
"""

import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from app.simulator.memory import Memory, invent_records
from app.simulator.module import SimulatedModule
from app.simulator.options import OptionTarget, Setup, fields_of, setup_from
from app.simulator.physics import Physics
from app.simulator.wire import Faults, Wire
from protocol.catalogue import BAUD
from protocol.messages import Source

DEFAULT_NAME = "module"
Clock = Callable[[], float]


@dataclass(frozen=True, slots=True, kw_only=True)
class BenchState:
    """What the bench shows at one moment, for a panel."""

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
    """Of the module's line now."""
    rate_hz: float
    values: Mapping[str, Any]
    """Of the dialect and the faults, by option name."""


class SimulatedBench:
    """Every method may be called from any thread. `changed` is notified whenever something may have become due."""

    def __init__(self, setup: Setup | None = None, *, clock: Clock = time.monotonic) -> None:
        setup = setup or Setup()
        self.changed = threading.Condition(threading.RLock())
        self.clock = clock
        self.world = Physics(
            tilt_deg=setup.tilt, bay_is_open=setup.bay_open, has_external_power=setup.charger, cell_v=setup.cell,
            drain_v_per_h=setup.drain, noise=setup.noise, is_lifelike=setup.lifelike, seed=setup.seed,
        )  # fmt: skip
        # Powering on counts one boot; the option says what is read afterwards.
        memory = Memory(boot_count=setup.boots, baud_code=BAUD.encode(setup.baud))
        invent_records(memory, setup.history, seed=setup.seed, has_odd_voltage=setup.quirks.odd_voltage)
        memory.boot_count = (setup.boots - 1) & 0xFF
        self.module = SimulatedModule(self.world, setup.quirks, memory=memory, rate_hz=setup.rate)
        self.wire = Wire(self.module, setup.faults, seed=setup.seed)
        self.plug_number = 1
        """Counts how often it was plugged in: who opened an earlier one has a dead port."""
        self.last_options: Mapping[str, Any] = {}
        """Of the last opening, by option name."""
        self._is_plugged_in = True
        self._replug_s: float | None = None
        self._holder: object | None = None
        now_s = clock()
        self.module.power_on(now_s - setup.uptime)
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
        """Let it fall from this height."""
        with self._act() as now_s:
            self.world.drop(height_m, now_s)

    def set_bay(self, *, is_open: bool) -> None:
        with self._act():
            self.world.bay_is_open = is_open

    def set_cell(self, cell_v: float) -> None:
        with self._act():
            self.world.cell_v = cell_v

    def set_charger(self, *, is_plugged_in: bool) -> None:
        """External power; plugging it wakes a module that was shut down."""
        with self._act() as now_s:
            if is_plugged_in:
                self.module.plug_charger(now_s)
            else:
                self.module.unplug_charger(now_s)

    def set_lifelike(self, *, is_lifelike: bool) -> None:
        with self._act():
            self.world.is_lifelike = is_lifelike

    def set_noise(self, noise: float) -> None:
        with self._act():
            self.world.noise = noise

    def pulse_pwm(self) -> bool:
        """Trigger by its PWM input; False when it does not fire."""
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

    def unplug(self, *, for_s: float | None = None) -> None:
        """Pull the serial adapter; with `for_s` it comes back by itself after that time."""
        with self._act() as now_s:
            self.wire.clear(now_s)
            self._is_plugged_in = False
            self._replug_s = None if for_s is None else now_s + for_s
            self._holder = None

    def plug(self) -> None:
        """Plug the serial adapter in again: a new one, as far as open ports are concerned."""
        with self._act():
            if not self._is_plugged_in:
                self._plug()

    def _plug(self) -> None:
        self.wire.clear(self.clock())
        self._is_plugged_in = True
        self._replug_s = None
        self.plug_number += 1

    @property
    def is_plugged_in(self) -> bool:
        with self.changed:
            if self._replug_s is not None and self.clock() >= self._replug_s:
                self._plug()
            return self._is_plugged_in

    @property
    def plugged(self) -> int | None:
        """`plug_number` while it is plugged in, else None."""
        with self.changed:
            return self.plug_number if self.is_plugged_in else None

    @property
    def replug_s(self) -> float | None:
        """When it comes back by itself, on the bench's clock."""
        return self._replug_s

    # Its ways

    def change(self, **values: Any) -> None:
        """Set options of the dialect, the faults, and `rate`, by option name."""
        with self._act():
            self.module.quirks = replace(self.module.quirks, **fields_of(values, OptionTarget.DIALECT))
            self.wire.faults = replace(self.wire.faults, **fields_of(values, OptionTarget.FAULTS))
            if "rate" in values:
                self.module.rate_hz = values["rate"]

    def heal(self) -> None:
        """End all faults of the line."""
        with self._act():
            self.wire.faults = Faults()

    def state(self) -> BenchState:
        """Everything that the bench shows, at one moment."""
        with self._act() as now_s:
            module, world = self.module, self.world
            quirks, faults = self.module.quirks, self.wire.faults
            return BenchState(
                tilt_deg=world.tilt_deg, is_falling=world.is_falling(now_s),
                is_lifelike=world.is_lifelike, bay_is_open=world.bay_is_open,
                cell_v=world.cell_v, has_external_power=world.has_external_power, is_on=module.is_on,
                is_plugged_in=self.is_plugged_in, is_active=module.state.is_active, is_triggered=module.is_triggered,
                is_streaming=module.is_streaming, boot_count=module.memory.boot_count,
                record_count=len(module.memory.records), baud_rate=module.baud_rate, rate_hz=module.rate_hz,
                values={name: getattr(part, name) for part in (quirks, faults) for name in part.__slots__},
            )  # fmt: skip

    # Its port

    def hold(self, holder: object) -> bool:
        """Take the port for oneself; False when it is taken."""
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

    def _act(self) -> "_Act":
        return _Act(self)


class _Act:
    """Holds the lock, lets the time pass first, and wakes whoever waits for bytes afterwards."""

    def __init__(self, bench: SimulatedBench) -> None:
        self._bench = bench

    def __enter__(self) -> float:
        bench = self._bench
        bench.changed.acquire()
        now_s = bench.clock()
        bench.module.advance(now_s)
        return now_s

    def __exit__(self, *_: object) -> None:
        self._bench.changed.notify_all()
        self._bench.changed.release()


_benches: dict[str, SimulatedBench] = {}
_benches_lock = threading.Lock()


def module(name: str = DEFAULT_NAME, options: Mapping[str, Any] | None = None) -> SimulatedBench:
    """The module of this name, made when it is first asked for.

    `options` are parsed values by option name. One that runs already takes over those of the dialect, of the faults and
    the rate, if they are not the last ones: opening the same URL again does not undo what was changed at the bench
    since. How it began and how it lies stays as it is.
    """
    options = dict(options or {})
    with _benches_lock:
        bench = _benches.get(name)
        if bench is None:
            bench = _benches[name] = SimulatedBench(setup_from(options))
            bench.last_options = options
            return bench
        is_news = options not in ({}, bench.last_options)
        if is_news:
            bench.last_options = options
    if is_news:
        bench.change(**options)
    return bench


def forget(name: str = DEFAULT_NAME) -> None:
    """Throw the module of this name away; the next one is new. An open port of it goes dead."""
    with _benches_lock:
        bench = _benches.pop(name, None)
    if bench is not None:
        bench.unplug()
