"""The simulated module with more faults than the product shows, for what runs on `sim://`.

Every simulated module of the test's process is one (`install`), and honest until an option says otherwise. Dialects and
lies are tried against `tests.module`.
"""

import random
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields
from functools import partial
from typing import Any, Final

from app.flights.judge import SensorSample
from app.simulator import bench as benches
from app.simulator import setup as setups
from app.simulator.bench import Clock, SimulatedBench, Wire
from app.simulator.module import (
    BITS_PER_BYTE,
    BOOT_GAP_S,
    LIGHT_BAY_CLOSED_V,
    LIGHT_BAY_OPEN_V,
    Memory,
    Physics,
    SimulatedModule,
    to_byte,
)
from app.simulator.setup import Setup, number, one_of, option, switch
from protocol.catalogue import INVERTED, TENTH_VOLT, Request
from protocol.messages import encode_reply

MAX_GARBAGE_LENGTH = 12
WAYS: Final = {way: way for way in ("to-host", "to-module", "both")}


def as_text(value: object) -> str:
    """A value in the form in which it is typed."""
    if isinstance(value, frozenset):
        return ",".join(f"{code:X}" for code in value)
    return setups.as_text(value)


def _codes(text: str) -> frozenset[int]:
    return frozenset(int(code, 16) for code in text.replace(",", " ").split())


_share: Callable[[], Any] = partial(number, 0.0, "a fault", "SHARE", 0, 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class OddSetup(Setup):
    noise: float = number(0.0, "of the sensors; 1 is typical", "N", 0, 100)
    light_inverted: bool = switch("a dialect (E11)")
    stream_at_boot: bool = switch("a dialect")
    refuses: bool = switch("no setting changes")
    mute_codes: frozenset[int] = option(frozenset(), "not answered and not carried out", "CODE,…", _codes)
    garbage: float = _share()
    direction: str = one_of("to-host", "of drop, corrupt and garbage", "|".join(WAYS), WAYS)
    delay_ms: float = number(0.0, "a fault", "MS", 0, 10_000)
    echo: bool = switch("a fault")


LINE_FAULTS: Final = ("mute", "drop", "corrupt", "lag_ms", "garbage", "direction", "delay_ms", "echo")


def odd_bench(options: Mapping[str, Any], clock: Clock) -> SimulatedBench:
    """A module with these options, as values or as they are typed."""
    texts = {name: as_text(value) for name, value in options.items()}
    return SimulatedBench(OddSetup(**setups.parse_options(texts)), clock=clock)


def install() -> None:
    """Make every simulated module of this process one that may be odd, also behind `sim://`."""
    vars(setups)["Setup"] = OddSetup
    vars(benches).update(Setup=OddSetup, Wire=OddWire, SimulatedModule=OddModule)


def end_faults(bench: SimulatedBench) -> None:
    """End all faults of the line."""
    bench.change(**{one.name: one.default for one in fields(OddSetup) if one.name in LINE_FAULTS})


def odd(module: SimulatedModule) -> OddSetup:
    assert isinstance(module.setup, OddSetup)
    return module.setup


def forget_settings(memory: Memory) -> None:
    """Make its settings those of a new module."""
    fresh = Memory()
    for name in ("light_threshold", "attitude_threshold", "freefall_acceleration", "freefall_time"):
        setattr(memory, name, getattr(fresh, name))


def restart_silently(bench: SimulatedBench, now_s: float) -> None:
    """Restart it without its two heartbeats."""
    module = bench.module
    module.power_on(now_s)
    module._out.pop()
    module._booted_s += 1e-9  # so that the second one is no longer due


class OddModule(SimulatedModule):
    def __init__(self, world: Physics, setup: Setup | None = None, *, memory: Memory | None = None) -> None:
        if not isinstance(setup, OddSetup):
            setup = OddSetup(**({} if setup is None else asdict(setup)))
        self._noise = random.Random(setup.seed)
        super().__init__(world, setup, memory=memory)

    def obey(self, request: Request, now_s: float) -> None:
        command = request.command
        if command.code in odd(self).mute_codes:
            return
        if odd(self).refuses and request.is_set and command.is_setting:
            self.send(encode_reply(command.code, self._held(request)), now_s)
        else:
            super().obey(request, now_s)

    def _held(self, request: Request) -> int:
        """The byte that stands, with which a set is refused."""
        name = request.command.name
        if name in ("attitude_trigger", "freefall_trigger"):
            return INVERTED.encode(getattr(self.state, name.replace("trigger", "is_enabled")))
        return int(getattr(self.memory, name))

    def power_on(self, now_s: float) -> None:
        setup = odd(self)
        super().power_on(now_s)
        if setup.stream_at_boot:
            self.state.serial_output_is_on = True
            self._stream_due_s = now_s + 2 * BOOT_GAP_S + 1 / setup.rate

    def measure(self, now_s: float) -> SensorSample:
        sample = super().measure(now_s)
        if not odd(self).noise:
            return sample
        return sample._replace(
            tilt_deg=abs(sample.tilt_deg + self._hiss(0.4)),
            acceleration_g=max(0.0, sample.acceleration_g + self._hiss(0.03)),
        )

    def _hiss(self, typical: float) -> float:
        return self._noise.gauss(0.0, typical * odd(self).noise)

    def light(self) -> int:
        volts = self.world.light_v + self._hiss(0.03)
        if odd(self).light_inverted:
            volts = LIGHT_BAY_CLOSED_V + LIGHT_BAY_OPEN_V - volts
        return to_byte(volts * TENTH_VOLT.per_unit)


HonestWire = Wire


class OddWire(Wire):
    """A line with every fault there is, towards the host, the module, or both."""

    def write(self, data: bytes, now_s: float) -> None:
        if not data:
            return
        faults = odd(self.module)
        byte_s = BITS_PER_BYTE / (self.host_baud or self.module.baud_rate)
        ends_s = max(now_s, self._free_s) + len(data) * byte_s
        if faults.echo:
            self.deliver(data, ends_s)
        worn = data if faults.direction == "to-host" else self._worn(data)
        if worn:
            super().write(worn, now_s)
        self._free_s = max(self._free_s, ends_s)

    def suffer(self, data: bytes, at_s: float) -> None:
        faults = odd(self.module)
        if worn := data if faults.direction == "to-module" else self._worn(data):
            self.deliver(worn, at_s + faults.delay_ms / 1000)

    def _worn(self, data: bytes) -> bytes:
        faults, source = odd(self.module), self._random
        if faults.drop and source.random() < faults.drop:
            return b""
        if faults.corrupt:
            data = bytes(self._turned(byte) if source.random() < faults.corrupt else byte for byte in data)
        if faults.garbage and source.random() < faults.garbage:
            data = source.randbytes(source.randint(1, MAX_GARBAGE_LENGTH)) + data
        return data
