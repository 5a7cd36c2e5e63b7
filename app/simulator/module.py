"""The simulated module, what it remembers, and its world: bytes and time in, bytes out, as the vendor's table says.

    power_on -> two heartbeats 50 ms apart -> answers, streams while serial output is on -> power_off -> silence

It has no clock and no thread: every method takes `now_s`, seconds of one monotonic clock. What is due until then
happens when it is called; the sensor is read 200 times a second.

Where the table does not tell, this module answers `11 01` with 00 while it is locked, and does not fire; ends
"triggered" at the reset angle after an attitude trigger, and with `10 00`, `11 00` or a restart after others; blocks
all triggers from `11 00` until `11 01`, `10` or a restart; sends nine records, the oldest first, and 00 for those never
used; acknowledges a set with its value, and a new baud rate at the old one; does not answer what is no valid frame.
"""

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from operator import itemgetter
from typing import NamedTuple

from app.flights.judge import NOTHING, Judge, SensorSample, TriggerLimits
from app.simulator.setup import Setup
from protocol.catalogue import (
    BAUD,
    CELL_VOLT,
    CENTISECOND,
    FLAG,
    HEARTBEAT_REPLY,
    INVERTED,
    MAX_RECORDS,
    QUERY,
    RECORD_CODE,
    STATUS_CODE,
    TENTH_G,
    TENTH_VOLT,
    Layout,
    Request,
)
from protocol.messages import Direction, Frame, Source, decode_request, encode_long, encode_record_data, encode_reply
from protocol.stream import StreamParser

GRAVITY_M_S2 = 9.81
FALLING_G = 0.02  # air drag leaves a little
JOLT_G, JOLT_S = 5.0, 0.1  # at the end of a fall, on the ground or as the parachute holds
OPENING_S = 0.2  # from the trigger until the parachute holds; the module falls until then
CHARGER_LIFT_V = 0.1  # "有外接电源测量有误差": with external power its voltage is read, not the cell's
LIGHT_BAY_CLOSED_V = 0.3
LIGHT_BAY_OPEN_V = 2.5  # more light reads higher (E11)
SENSOR_PERIOD_S = 0.005


@dataclass(slots=True, kw_only=True)
class Physics:
    """The module's world: attitude, fall, light and cell voltage. Its public fields may be changed at any time. A
    lifelike module moves by a few degrees, as in somebody's hand. The cell neither drains nor charges."""

    tilt_deg: float = 0.0
    bay_is_open: bool = False
    has_external_power: bool = False
    cell_v: float = 3.9
    is_lifelike: bool = False
    _falls_from_s: float = math.inf
    _falls_until_s: float = -math.inf

    def drop(self, height_m: float, now_s: float) -> None:
        self._falls_from_s = now_s
        self._falls_until_s = now_s + math.sqrt(2 * max(0.0, height_m) / GRAVITY_M_S2)

    def open_parachute(self, now_s: float) -> None:
        """The module has fired: the bay is open, and a fall ends as soon as the parachute holds."""
        self.bay_is_open = True
        self._falls_until_s = min(self._falls_until_s, now_s + OPENING_S)

    def is_falling(self, now_s: float) -> bool:
        return self._falls_from_s <= now_s < self._falls_until_s

    def motion(self, at_s: float) -> tuple[float, float]:
        """The tilt against the horizontal plane, signed, before zeroing, in degrees; and the acceleration in g."""
        tilt_deg = self.tilt_deg
        acceleration_g = 1.0
        if self.is_lifelike:
            tilt_deg += 4.0 + 2.4 * math.sin(0.83 * at_s) + 1.1 * math.sin(2.27 * at_s + 1.0)
            acceleration_g += 0.06 * math.sin(1.7 * at_s) + 0.05 * math.sin(5.1 * at_s)
        if self.is_falling(at_s):
            acceleration_g = FALLING_G
        elif self._falls_until_s <= at_s < self._falls_until_s + JOLT_S:
            acceleration_g = JOLT_G
        return tilt_deg, acceleration_g


@dataclass(slots=True, kw_only=True)
class Memory:
    """The memory that survives a restart; bytes as on the wire. `records` are their eleven data bytes (D4 … D14),
    oldest first."""

    light_threshold: int = 0x12
    attitude_threshold: int = 60
    freefall_acceleration: int = 5
    freefall_time: int = 160
    baud_code: int = 6
    boot_count: int = 0
    zero_tilt_deg: float = 0.0
    records: deque[bytes] = field(default_factory=lambda: deque(maxlen=MAX_RECORDS))


@dataclass(slots=True, kw_only=True)
class ModuleState:
    """The state that a restart resets. A module begins locked, with both triggers enabled."""

    is_active: bool = False
    attitude_is_enabled: bool = True
    freefall_is_enabled: bool = True
    # After `11 00` nothing fires until `11 01`, `10` or a restart; the table names no end (E15).
    is_forbidden: bool = False


BOOT_GAP_S = 0.05  # "间隔50ms"
ANSWERED_UNDER = {0x17: 0x16, 0x34: 0x35}  # E4 and E3: the codes that the table prints
EMPTY_SLOT = bytes(11)
HOST_SILENT_S = 30.0  # the host sends a heartbeat every 10 to 30 s; later, a record says that serial is not connected
# Where nobody looked for longer, the stream and the sensor skip the time before: hours take no longer than seconds.
MAX_LOOK_BACK_S = 10.0
MAX_WAITING = 4096  # bursts that nobody took; older ones are lost, as in a driver's buffer that is full
BITS_PER_BYTE = 10


class SentBytes(NamedTuple):
    """One burst; `ends_s` is when its last bit leaves."""

    ends_s: float
    data: bytes
    baud_rate: int


def to_byte(value: float) -> int:
    return min(255, max(0, round(value)))


class SimulatedModule:
    """Begins switched off. `world`, `memory` and `state` may be changed between two calls."""

    def __init__(self, world: Physics, setup: Setup | None = None, *, memory: Memory | None = None) -> None:
        self.world = world
        self.setup = setup or Setup()
        self.memory = memory or Memory()
        self.state = ModuleState()
        self.baud_rate = BAUD.values[self.memory.baud_code]
        self.is_on = False
        self._judge = Judge()
        self._fired = NOTHING
        self._plans: list[tuple[float, Callable[[float], object]]] = []
        self.out: deque[SentBytes] = deque(maxlen=MAX_WAITING)
        self._line_free_s = -math.inf
        self._stream_due_s = math.inf
        self._booted_s = 0.0
        self._sampled_s = -math.inf
        self._heard = StreamParser()
        self._heard_s = -math.inf

    @property
    def is_triggered(self) -> bool:
        return self._fired is not NOTHING

    @property
    def is_streaming(self) -> bool:
        return self._stream_due_s != math.inf

    # What it measures

    def measure(self, now_s: float) -> SensorSample:
        tilt_deg, acceleration_g = self.world.motion(now_s)
        return SensorSample(now_s, abs(tilt_deg - self.memory.zero_tilt_deg), acceleration_g)

    def light(self) -> int:
        light_v = LIGHT_BAY_OPEN_V if self.world.bay_is_open else LIGHT_BAY_CLOSED_V
        return to_byte(light_v * TENTH_VOLT.per_unit)

    def voltage(self) -> int:
        lift_v = CHARGER_LIFT_V if self.world.has_external_power else 0.0
        return to_byte((self.world.cell_v + lift_v) * CELL_VOLT.per_unit)

    def status(self, now_s: float) -> bytes:
        sample = self.measure(now_s)
        tilt = to_byte(sample.tilt_deg)
        acceleration = to_byte(sample.acceleration_g * TENTH_G.per_unit)
        return encode_long(STATUS_CODE, bytes((tilt, acceleration, self.is_triggered, self.state.is_active)))

    # Power

    def power_on(self, now_s: float) -> None:
        """Boot, also again: count it (0 follows 255), lock, enable both triggers, and send two heartbeats."""
        self.power_off()
        self.is_on = True
        self.memory.boot_count = (self.memory.boot_count + 1) & 0xFF
        self.baud_rate = BAUD.values[self.memory.baud_code]
        self._booted_s = now_s
        self._sampled_s = now_s
        self.send(HEARTBEAT_REPLY, now_s)

        def beat_again(at_s: float) -> None:
            # Not where it was switched off since, or off and on.
            if self.is_on and at_s == self._booted_s + BOOT_GAP_S:
                self.send(HEARTBEAT_REPLY, at_s)

        self.plan(now_s + BOOT_GAP_S, beat_again)

    def power_off(self) -> None:
        self.is_on = False
        self.state = ModuleState()
        self._heard = StreamParser()
        self._heard_s = -math.inf
        self.stop_stream()
        self.end_trigger()

    # Triggers

    def activate(self, *, is_active: bool) -> None:
        """Activate or lock it. Both end a block of the triggers; locking also ends "triggered"."""
        self.state.is_active = is_active
        self.state.is_forbidden = False
        if not is_active:
            self.end_trigger()

    def end_trigger(self) -> None:
        self._fired = NOTHING
        self._judge.reset()

    def fire(self, sources: Source, now_s: float) -> bool:
        if not self.state.is_active or self.state.is_forbidden:
            return False
        self._fired |= sources
        raws = {
            "boot_count": self.memory.boot_count,
            "uptime_s": min(0xFFFF, int(now_s - self._booted_s)),  # "最高记录65535秒"
            "sources": sources.value,
            "attitude_threshold_deg": self.memory.attitude_threshold,
            "freefall_acceleration_g": self.memory.freefall_acceleration,
            "freefall_time_s": self.memory.freefall_time,
            "serial_connected": INVERTED.encode(now_s - self._heard_s <= HOST_SILENT_S),
            "charging": INVERTED.encode(self.world.has_external_power),
            "light_v": self.light(),
            "cell_voltage_v": self.voltage(),
        }
        self.memory.records.append(encode_record_data(raws))
        self.world.open_parachute(now_s)
        return True

    def _watch(self, until_s: float) -> None:
        if not self.state.is_active:
            self._sampled_s = until_s
            return
        self._sampled_s = max(self._sampled_s, until_s - MAX_LOOK_BACK_S)
        while self._sampled_s + SENSOR_PERIOD_S <= until_s:
            self._sampled_s += SENSOR_PERIOD_S
            self._sense(self._sampled_s)

    def _sense(self, at_s: float) -> None:
        memory, state = self.memory, self.state
        limits = TriggerLimits(
            attitude_threshold_deg=memory.attitude_threshold,
            freefall_acceleration_g=memory.freefall_acceleration / TENTH_G.per_unit,
            freefall_time_s=memory.freefall_time / CENTISECOND.per_unit,
            attitude_is_enabled=state.attitude_is_enabled,
            freefall_is_enabled=state.freefall_is_enabled,
        )
        is_armed = state.is_active and not state.is_forbidden
        verdict = self._judge.judge(self.measure(at_s), limits, is_active=is_armed)
        if self.is_triggered and Source.ATTITUDE not in verdict.standing:
            self._fired &= ~Source.ATTITUDE
        if verdict.fired is not NOTHING:
            self.fire(verdict.fired, at_s)

    # Time, and what leaves it

    def plan(self, at_s: float, act: Callable[[float], object]) -> None:
        self._plans = sorted([*self._plans, (at_s, act)], key=itemgetter(0))

    def advance(self, now_s: float) -> None:
        self._stream_due_s = max(self._stream_due_s, now_s - MAX_LOOK_BACK_S)
        while (due_s := self.due_s) <= now_s:
            self._watch(due_s)
            if self._plans and self._plans[0][0] == due_s:
                self._plans.pop(0)[1](due_s)
            else:
                self._stream_due_s += 1 / self.setup.rate
                # Not where the line is a whole frame behind: no queue grows.
                if self._line_free_s - due_s <= Layout.STATUS.value * BITS_PER_BYTE / self.baud_rate:
                    self.send(self.status(due_s), due_s)
        self._watch(now_s)

    @property
    def due_s(self) -> float:
        """When it does something by itself; infinity for never."""
        return min(self._plans[0][0] if self._plans else math.inf, self._stream_due_s)

    def send(self, data: bytes, now_s: float) -> None:
        """Send a burst into `out`, behind what its line still carries."""
        begins_s = max(now_s, self._line_free_s)
        self._line_free_s = begins_s + len(data) * BITS_PER_BYTE / self.baud_rate
        self.out.append(SentBytes(self._line_free_s, data, self.baud_rate))

    def start_stream(self, now_s: float) -> None:
        self._stream_due_s = now_s + 1 / self.setup.rate

    def stop_stream(self) -> None:
        self._stream_due_s = math.inf

    # Requests

    def receive(self, data: bytes, now_s: float) -> None:
        self.advance(now_s)
        for piece in self._heard.feed(data):
            if self.is_on and isinstance(piece, Frame) and piece.direction is Direction.HOST_TO_MODULE:
                self._heard_s = now_s
                self.obey(decode_request(piece.raw), now_s)

    def obey(self, request: Request, now_s: float) -> None:
        code, name = request.command.code, request.command.name
        if name == "heartbeat":
            self.send(HEARTBEAT_REPLY, now_s)
        elif name == "status":
            self.send(self.status(now_s), now_s)
        elif name == "trigger_records":
            empty = [EMPTY_SLOT] * (MAX_RECORDS - len(self.memory.records))
            for data in [*self.memory.records, *empty]:
                self.send(encode_long(RECORD_CODE, bytes((QUERY,)) + data), now_s)
        else:
            said = self._set(name, request.data, now_s) if request.is_set else self._value(name, now_s)
            self.send(encode_reply(ANSWERED_UNDER.get(code, code), said), now_s)
        if name == "baud_rate":
            self.baud_rate = BAUD.values[self.memory.baud_code]

    def _set(self, name: str, data: int, now_s: float) -> int:
        match name:
            case "activation":
                self.activate(is_active=data == FLAG.true)
            case "deploy" if data == FLAG.true:
                self.state.is_forbidden = False
                return self.fire(Source.SERIAL, now_s)
            case "deploy":
                self.state.is_forbidden = True
                self.end_trigger()
            case "shutdown":
                self.power_off()
            case "serial_output":
                if data == FLAG.true:
                    self.start_stream(now_s)
                else:
                    self.stop_stream()
            case "attitude_trigger":
                self.state.attitude_is_enabled = data == INVERTED.true
            case "freefall_trigger":
                self.state.freefall_is_enabled = data == INVERTED.true
            case "baud_rate":
                self.memory.baud_code = data
            case threshold:
                setattr(self.memory, threshold, data)
        return data

    def _value(self, name: str, now_s: float) -> int:
        match name:
            case "light":
                return self.light()
            case "cell_voltage":
                return self.voltage()
            case "charging":
                return self.world.has_external_power
            case "active":
                return self.state.is_active
            case "triggered":
                return self.is_triggered
            case "zero_sensor":
                self.memory.zero_tilt_deg = self.world.motion(now_s)[0]
                return True
            case threshold_or_boot_count:
                return int(getattr(self.memory, threshold_or_boot_count))
