"""The simulated module with the dialects that the vendor's table leaves open, and with faults that no product shows.

Every simulated module of the test's process is one (`install`), and honest until an option says otherwise. What the
product itself does with other dialects is tried against `tests.module`.
"""

import random
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields
from functools import partial
from typing import Any, Final

from app.flights.judge import SensorSample
from app.simulator import bench as benches
from app.simulator import setup as setups
from app.simulator.bench import Clock, SimulatedBench, Wire
from app.simulator.module import (
    ACCEPTED,
    BITS_PER_BYTE,
    BOOT_GAP_S,
    EMPTY_SLOT,
    LIGHT_BAY_CLOSED_V,
    LIGHT_BAY_OPEN_V,
    Memory,
    Physics,
    SimulatedModule,
    record_frame,
    to_byte,
)
from app.simulator.setup import Setup, number, one_of, option, switch
from protocol.catalogue import FLAG, INVERTED, LOCK, MAX_RECORDS, RECORD_CODE, TENTH_VOLT, Request
from protocol.fields import Flag
from protocol.messages import encode_reply

Mark = int | tuple[int, int]
"""A code or number, or one with the n-th time."""
MAX_GARBAGE_LENGTH = 12
RECORD_GAP_S = 0.02
FAILED = 0x00
IN_MEMORY: Final = {
    0x15: "light_threshold", 0x20: "attitude_threshold", 0x21: "freefall_acceleration", 0x22: "freefall_time",
    0x24: "baud_code",
}  # fmt: skip
IN_STATE: Final[Mapping[int, tuple[str, Flag]]] = {
    0x10: ("is_active", FLAG), 0x13: ("serial_output_is_on", FLAG),
    0x16: ("attitude_is_enabled", INVERTED), 0x17: ("freefall_is_enabled", INVERTED),
}  # fmt: skip


def as_text(value: object) -> str:
    """A value in the form in which it is typed."""
    if isinstance(value, frozenset):
        return ",".join(f"{code:X}" for code in value)
    return setups.as_text(value)


def _word(*words: str) -> Any:
    """One of these, by default the first."""
    return one_of(words[0], "a dialect", "|".join(words), dict(zip(words, words, strict=True)))


def _code(default: int) -> Any:
    return option(default, "a dialect", "CODE", partial(int, base=16))


def _marks(base: int) -> Any:
    def parse(text: str) -> frozenset[Mark]:
        parts = [part.partition("/") for part in text.replace(",", " ").split()]
        return frozenset((int(what, base), int(time)) if time else int(what, base) for what, _, time in parts)

    return option(frozenset(), "a lie", "MARK,…", parse)


_quirk: Callable[[], Any] = partial(switch, "a dialect")
_share: Callable[[], Any] = partial(number, 0.0, "a fault", "SHARE", 0, 1)
_milliseconds: Callable[[], Any] = partial(number, 0.0, "a fault", "MS", 0, 10_000)


@dataclass(frozen=True, slots=True, kw_only=True)
class OddSetup(Setup):
    """Names in brackets are explained in `docs/protocol.md`."""

    noise: float = number(0.0, "of the sensors; 1 is typical", "N", 0, 100)
    ack: str = _word("echo", "one")
    """(E2)"""
    voltage_code: int = _code(0x35)
    """(E3)"""
    freefall_ack: int = _code(0x16)
    """(E4)"""
    records: str = _word("together", "spaced")
    """(E6)"""
    empty_slots: str = _word("zeros", "ones", "none")
    """(E7)"""
    light_inverted: bool = _quirk()
    """(E11)"""
    stream: str = _word("yes", "acknowledged", "silent")
    stream_at_boot: bool = _quirk()
    refuses: bool = _quirk()
    locks: bool = switch("a lie", default=True)
    shuts_down: bool = switch("a lie", default=True)
    mute_codes: frozenset[Mark] = _marks(16)
    """Ignored; `35/2`: from the second time on."""
    drop_records: frozenset[Mark] = _marks(10)
    """By number; `1/2`: in the second reply only."""
    double_codes: frozenset[Mark] = _marks(16)
    double_ms: float = _milliseconds()
    """After the reply to one of these codes comes again."""
    garbage: float = _share()
    direction: str = _word("to-host", "to-module", "both")
    """Of drop, corrupt and garbage."""
    delay_ms: float = _milliseconds()
    echo: bool = switch("a fault")


LINE_FAULTS: Final = ("mute", "drop", "corrupt", "lag_ms", "garbage", "direction", "delay_ms", "echo")


def odd_bench(options: Mapping[str, Any], clock: Clock) -> SimulatedBench:
    """A module with these options, as values or as they are typed."""
    texts = {name: as_text(value) for name, value in options.items()}
    return SimulatedBench(OddSetup(**setups.parse_options(texts)), clock=clock, kind=OddModule)


def install() -> None:
    """Make every simulated module of this process one that may be odd, also behind `sim://`."""
    vars(setups)["parse_options"].__kwdefaults__["kind"] = OddSetup
    vars(benches)["Setup"] = OddSetup
    vars(benches)["Wire"] = OddWire
    vars(SimulatedBench)["__init__"].__kwdefaults__["kind"] = OddModule


def end_faults(bench: SimulatedBench) -> None:
    """End all faults of the line."""
    bench.change(**{one.name: one.default for one in fields(OddSetup) if one.name in LINE_FAULTS})


def odd(module: SimulatedModule) -> OddSetup:
    assert isinstance(module.setup, OddSetup)
    return module.setup


def read_raw(module: SimulatedModule, code: int) -> int:
    """The present byte of a setting or a state."""
    if code in IN_MEMORY:
        return int(getattr(module.memory, IN_MEMORY[code]))
    name, field = IN_STATE[code]
    return field.encode(getattr(module.state, name))


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
    """Carries out a set as its dialect says, and changes the reply on its way out."""

    def __init__(self, world: Physics, setup: Setup | None = None, *, memory: Memory | None = None) -> None:
        self._acknowledgement: int | None = None
        """D4 of the reply to the set that is carried out, in place of what an honest module says."""
        self._answering = 0
        """The code of the request that is carried out."""
        self._asked = Counter[int]()
        """How often each code was asked for."""
        if not isinstance(setup, OddSetup):
            setup = OddSetup(**({} if setup is None else asdict(setup)))
        self._noise = random.Random(setup.seed)
        super().__init__(world, setup, memory=memory)

    def obey(self, request: Request, now_s: float) -> None:
        setup, code = odd(self), request.command.code
        self._asked[code] += 1
        if any(code == mark or (isinstance(mark, tuple) and mark[0] == code and self._asked[code] >= mark[1])
               for mark in setup.mute_codes):  # fmt: skip
            return
        before = len(self._out)
        if code == 0x12 and not setup.shuts_down:
            self.send(encode_reply(code, ACCEPTED), now_s)
        else:
            self.carry_out(request, now_s)
        for sent in list(self._out)[before:] if code in setup.double_codes else ():
            self.plan(now_s + setup.double_ms / 1000, partial(self.send_while_on, sent.data, self._booted_s))

    def carry_out(self, request: Request, now_s: float) -> None:
        setup = odd(self)
        code = request.command.code
        self._answering = code
        if code == RECORD_CODE:
            self._send_records(now_s)
        elif code != 0x13 or setup.stream != "silent":
            super().obey(self._kept(request), now_s)
        self._acknowledgement = None
        self._answering = 0
        if code == 0x13 and setup.stream == "acknowledged":
            self.stop_stream()

    def _kept(self, request: Request) -> Request:
        """The set that is really carried out."""
        setup, code = odd(self), request.command.code
        if not request.is_set or not (code in IN_MEMORY or code in IN_STATE):
            return request
        old = read_raw(self, code)
        by_one = setup.ack == "one" and request.command.acknowledged_by_one
        if setup.refuses and request.data != old:
            self._acknowledgement = FAILED if by_one else old
            return request._replace(data=old)
        self._acknowledgement = ACCEPTED if by_one else request.data
        return request if setup.locks or request != LOCK else request._replace(data=old)

    def send(self, data: bytes, now_s: float) -> None:
        setup = odd(self)
        if len(data) == 6 and self._answering:
            code, value = data[2], data[4]
            if self._acknowledgement is not None:
                value = self._acknowledgement
            if self._answering == 0x17:
                code = setup.freefall_ack
            if self._answering == 0x34:
                code = setup.voltage_code
            if code != 0x01:
                data = encode_reply(code, value)
        super().send(data, now_s)

    def _send_records(self, now_s: float) -> None:
        setup = odd(self)
        pass_number = self._asked[RECORD_CODE]
        dropped = {mark if isinstance(mark, int) else mark[0] for mark in setup.drop_records
                   if isinstance(mark, int) or mark[1] == pass_number}  # fmt: skip
        frames = [record_frame(data) for number, data in enumerate(self.memory.records, 1) if number not in dropped]
        fill = {"zeros": EMPTY_SLOT, "ones": b"\xff" * len(EMPTY_SLOT)}.get(setup.empty_slots)
        if fill is not None:
            frames += [record_frame(fill)] * (MAX_RECORDS - len(frames))
        for position, frame in enumerate(frames):
            if setup.records == "together":
                self.send(frame, now_s)
            else:
                self.plan(now_s + position * RECORD_GAP_S, partial(self.send_while_on, frame, self._booted_s))

    def send_while_on(self, data: bytes, booted_s: float, now_s: float) -> None:
        """Send it, unless the module was switched off since it was planned."""
        if self.is_on and self._booted_s == booted_s:
            self.send(data, now_s)

    # Power

    def power_on(self, now_s: float) -> None:
        setup = odd(self)
        super().power_on(now_s)
        if setup.stream_at_boot:
            self.state.serial_output_is_on = True
        if self.state.serial_output_is_on:
            self._stream_due_s = now_s + 2 * BOOT_GAP_S + 1 / setup.rate

    # Sensor

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

    def light(self, now_s: float) -> int:
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
