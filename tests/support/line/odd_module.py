"""The simulated module with the dialects that the vendor's table leaves open, and with faults that no product shows.

Every simulated module of the test's process is one (`install`), and honest until an option says otherwise. What the
product itself does with other dialects is tried against `tests.module`.
"""

# ruff: noqa: RUF009  an option is a field

import math
import random
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields
from enum import Enum, StrEnum
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
from app.simulator.setup import Setup, number, option, switch
from protocol.catalogue import FLAG, INVERTED, LOCK, MAX_RECORDS, RECORD_CODE, TENTH_VOLT, Request
from protocol.fields import Flag
from protocol.messages import encode_reply

Mark = int | tuple[int, int]
"""A code or number, or one with the n-th time."""
Acknowledge = StrEnum("Acknowledge", ["ECHO", "ONE"])
Delivery = StrEnum("Delivery", ["TOGETHER", "SPACED", "PIECES"])
EmptySlots = StrEnum("EmptySlots", ["NONE", "ZEROS", "ONES"])
Streaming = StrEnum("Streaming", ["YES", "ACKNOWLEDGED", "SILENT"])


class FaultDirection(StrEnum):
    """Direction in which drop, lose, corrupt, garbage and double apply."""

    TO_HOST = "to-host"
    TO_MODULE = "to-module"
    BOTH = "both"


MAX_GARBAGE_LENGTH = 12
PIECE_LENGTH = 7
"""Not a divisor of the frame length, so that pieces cross the ends of frames."""
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
    return str(value.value) if isinstance(value, Enum) else setups.as_text(value)


def _word(default: Enum) -> Any:
    return option(default, "a dialect", "WORD", type(default))


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
    ack: Acknowledge = _word(Acknowledge.ECHO)
    """(E2)"""
    voltage_code: int = _code(0x35)
    """(E3)"""
    freefall_ack: int = _code(0x16)
    """(E4)"""
    records: Delivery = _word(Delivery.TOGETHER)
    """(E6)"""
    empty_slots: EmptySlots = _word(EmptySlots.ZEROS)
    """(E7)"""
    light_inverted: bool = _quirk()
    """(E11)"""
    stream: Streaming = _word(Streaming.YES)
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
    lose: float = _share()
    garbage: float = _share()
    double: float = _share()
    direction: FaultDirection = option(FaultDirection.TO_HOST, "of faults", "WORD", FaultDirection)
    delay_ms: float = _milliseconds()
    jitter_ms: float = _milliseconds()
    split_ms: float = _milliseconds()
    echo: bool = switch("a fault")


LINE_FAULTS: Final = (
    "mute", "drop", "corrupt", "lag_ms", "lose", "garbage", "double", "direction", "delay_ms", "jitter_ms", "split_ms",
    "echo",
)  # fmt: skip


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
    assert isinstance(bench.module, OddModule)
    bench.module.restart(now_s, is_silent=True)


class OddModule(SimulatedModule):
    """Carries out a set as its dialect says, and changes the reply on its way out."""

    def __init__(self, world: Physics, setup: Setup | None = None, *, memory: Memory | None = None) -> None:
        self._acknowledgement: int | None = None
        """D4 of the reply to the set that is carried out, in place of what an honest module says."""
        self._answering = 0
        """The code of the request that is carried out."""
        self._asked = Counter[int]()
        """How often each code was asked for."""
        self._stream_held_until_s = -math.inf
        self.stream_frames_sent = 0
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
        elif code != 0x13 or setup.stream is not Streaming.SILENT:
            super().obey(self._kept(request), now_s)
        self._acknowledgement = None
        self._answering = 0
        if code == 0x13 and setup.stream is Streaming.ACKNOWLEDGED:
            self.stop_stream()

    def _kept(self, request: Request) -> Request:
        """The set that is really carried out."""
        setup, code = odd(self), request.command.code
        if not request.is_set or not (code in IN_MEMORY or code in IN_STATE):
            return request
        old = read_raw(self, code)
        by_one = setup.ack is Acknowledge.ONE and request.command.acknowledged_by_one
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
        fill = {EmptySlots.ZEROS: EMPTY_SLOT, EmptySlots.ONES: b"\xff" * len(EMPTY_SLOT)}.get(setup.empty_slots)
        if fill is not None:
            frames += [record_frame(fill)] * (MAX_RECORDS - len(frames))
        together = b"".join(frames)
        if setup.records is Delivery.PIECES:
            frames = [together[at : at + PIECE_LENGTH] for at in range(0, len(together), PIECE_LENGTH)]
            # No status lies between the pieces of a record.
            self._stream_held_until_s = now_s + len(frames) * RECORD_GAP_S
        for position, frame in enumerate(frames):
            if setup.records is Delivery.TOGETHER:
                self.send(frame, now_s)
            else:
                self.plan(now_s + position * RECORD_GAP_S, partial(self.send_while_on, frame, self._booted_s))

    def send_while_on(self, data: bytes, booted_s: float, now_s: float) -> None:
        """Send it, unless the module was switched off since it was planned."""
        if self.is_on and self._booted_s == booted_s:
            self.send(data, now_s)

    def stream(self, now_s: float) -> None:
        if now_s >= self._stream_held_until_s:
            waiting = len(self._out)
            super().stream(now_s)
            self.stream_frames_sent += len(self._out) - waiting

    # Power

    def power_on(self, now_s: float, *, is_silent: bool = False) -> None:
        """`is_silent`: without the two heartbeats."""
        setup = odd(self)
        super().power_on(now_s)
        self._stream_held_until_s = -math.inf
        if is_silent:
            self._out.pop()
            self._booted_s += 1e-9  # so that the second one is no longer due
        if setup.stream_at_boot:
            self.state.serial_output_is_on = True
        if self.state.serial_output_is_on:
            self._stream_due_s = now_s + 2 * BOOT_GAP_S + 1 / setup.rate

    def restart(self, now_s: float, *, is_silent: bool = False) -> None:
        self.power_on(now_s, is_silent=is_silent)

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
        if faults.direction is FaultDirection.TO_HOST:
            super().write(data, now_s)
            return
        for worn in self._worn(data):
            super().write(worn, now_s)
        self._free_s = max(self._free_s, ends_s)

    def suffer(self, data: bytes, at_s: float) -> None:
        faults = odd(self.module)
        delay_s = faults.delay_ms / 1000
        if faults.jitter_ms:
            delay_s += self._random.uniform(0.0, faults.jitter_ms) / 1000
        is_spared = faults.direction is FaultDirection.TO_MODULE
        for worn in [data] if is_spared else self._worn(data):
            for position, piece in enumerate(self._pieces(worn)):
                self.deliver(piece, at_s + delay_s + position * faults.split_ms / 1000)

    def _pieces(self, data: bytes) -> list[bytes]:
        if not odd(self.module).split_ms or len(data) < 2:
            return [data]
        cuts = sorted({self._random.randrange(1, len(data)) for _ in range(2)})
        return [data[start:end] for start, end in zip([0, *cuts], [*cuts, len(data)], strict=True)]

    def _worn(self, data: bytes) -> list[bytes]:
        """Return none, one or two bursts."""
        faults = odd(self.module)
        source = self._random
        if faults.drop and source.random() < faults.drop:
            return []
        if faults.lose:
            data = bytes(byte for byte in data if source.random() >= faults.lose)
        if faults.corrupt:
            data = bytes(self._turned(byte) if source.random() < faults.corrupt else byte for byte in data)
        if faults.garbage and source.random() < faults.garbage:
            data = source.randbytes(source.randint(1, MAX_GARBAGE_LENGTH)) + data
        if not data:
            return []
        return [data, data] if faults.double and source.random() < faults.double else [data]
