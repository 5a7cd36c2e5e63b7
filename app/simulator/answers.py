"""Simulated module: bytes and time in, bytes out, as the vendor's table says.

    power_on -> two heartbeats 50 ms apart -> answers, streams while serial output is on -> shut_down -> silence

No clock and no thread: every method takes `now_s`, seconds of one monotonic clock. The sensor is evaluated 200 times a
second, also afterwards, up to `MAX_WATCH_S` back.

Where the table does not tell, this module: answers `11 01` with 00 while it is locked, and does not fire; ends
"triggered" at the reset angle after an attitude trigger, and with `10 00`, `11 00` or a restart after others; blocks
all triggers from `11 00` until `11 01`, `10` or a restart; sends the oldest record first; does not answer invalid
frames.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from app.simulator.hardware import Hardware, SentBytes
from app.simulator.memory import RECORD_DATA_LENGTH, record_frame
from app.simulator.setup import Acknowledge, BaudChange, Delivery, EmptySlots, Setup, Streaming
from protocol.catalogue import BY_NAME, FLAG, HEARTBEAT_REPLY, INVERTED, MAX_RECORDS, Command, Request
from protocol.fields import Flag
from protocol.frame import encode_reply, requests_in
from protocol.messages import Source

PIECE_LENGTH = 7
"""Not a divisor of the frame length, so that pieces cross the ends of frames."""

RECORD_GAP_S = 0.02
ACCEPTED = 0x01
FAILED = 0x00
_CLAMPS = {
    BY_NAME["attitude_threshold"]: range(55, 91),
    BY_NAME["freefall_acceleration"]: range(1, 7),
    BY_NAME["freefall_time"]: range(50, 256),
    BY_NAME["light_threshold"]: range(1, 34),
}
"""Ranges that the vendor advises, or that the sensor can measure."""

Answer = Callable[[Hardware, Request, float], None]


class StoredSetting(NamedTuple):
    value: int
    acknowledgement: int
    """D4 of the reply."""


def clamped(command: Command, raw: int) -> int:
    """The nearest byte within the advised range."""
    allowed = _CLAMPS.get(command, range(256))
    return min(max(raw, allowed.start), allowed.stop - 1)


def store_setting(command: Command, new: int, old: int, setup: Setup) -> StoredSetting:
    """The outcome of a set of `command` from `old` to `new` (bytes)."""
    by_one = setup.ack is Acknowledge.ONE and command.acknowledged_by_one
    if setup.refuses and new != old:
        return StoredSetting(old, FAILED if by_one else old)
    value = clamped(command, new) if setup.clamps else new
    return StoredSetting(value if setup.keeps else old, ACCEPTED if by_one else value)


def answer(module: Hardware, request: Request, now_s: float) -> None:
    """Carry out a valid request and queue the reply."""
    _ANSWERS[request.command.name](module, request, now_s)


def reply(module: Hardware, code: int, value: int, now_s: float) -> None:
    module.send(encode_reply(code, value), now_s)


def _value(read: Callable[[Hardware, float], int]) -> Answer:
    """Answer of a command that reports one byte."""

    def report(module: Hardware, request: Request, now_s: float) -> None:
        module.advance(now_s)
        reply(module, request.command.code, read(module, now_s), now_s)

    return report


def _setting(attribute: str) -> Answer:
    """Answer of a setting in the memory that can be queried and set."""

    def ask_or_set(module: Hardware, request: Request, now_s: float) -> None:
        value: int = getattr(module.memory, attribute)
        if request.is_set:
            kept = store_setting(request.command, request.data, value, module.setup)
            setattr(module.memory, attribute, kept.value)
            value = kept.acknowledgement
        reply(module, request.command.code, value, now_s)

    return ask_or_set


def _flag(attribute: str, field: Flag) -> Answer:
    """Answer of a flag that can be set but not queried (E8)."""

    def set_flag(module: Hardware, request: Request, now_s: float) -> None:
        kept = _set_flag(module, request, attribute, field)
        code = request.command.code
        # E4: the table prints the acknowledgement of 17 with code 16.
        reply(module, module.setup.freefall_ack if code == 0x17 else code, kept.acknowledgement, now_s)

    return set_flag


def _set_flag(module: Hardware, request: Request, attribute: str, field: Flag) -> StoredSetting:
    old = field.encode(getattr(module.state, attribute))
    kept = store_setting(request.command, request.data, old, module.setup)
    setattr(module.state, attribute, kept.value == field.true)
    return kept


def _heartbeat(module: Hardware, _request: Request, now_s: float) -> None:
    module.send(HEARTBEAT_REPLY, now_s)


def _activation(module: Hardware, request: Request, now_s: float) -> None:
    kept = store_setting(request.command, request.data, int(module.state.is_active), module.setup)
    module.activate(is_active=kept.value == FLAG.true)
    reply(module, request.command.code, kept.acknowledgement, now_s)


def _deploy(module: Hardware, request: Request, now_s: float) -> None:
    if request.data == 0x01:
        module.state.is_forbidden = False
        has_fired = module.fire(Source.SERIAL, now_s)
        reply(module, request.command.code, int(has_fired), now_s)
    else:
        module.state.is_forbidden = True
        module.end_trigger()
        reply(module, request.command.code, 0x00, now_s)


def _shutdown(module: Hardware, request: Request, now_s: float) -> None:
    reply(module, request.command.code, ACCEPTED, now_s)
    module.shut_down(now_s)


def _serial_output(module: Hardware, request: Request, now_s: float) -> None:
    how = module.setup.stream
    if how is Streaming.SILENT:
        return
    kept = _set_flag(module, request, "serial_output_is_on", FLAG)
    reply(module, request.command.code, kept.acknowledgement, now_s)
    if module.state.serial_output_is_on and how is Streaming.YES:
        module.start_stream(now_s)
    else:
        module.stop_stream()


def _baud_rate(module: Hardware, request: Request, now_s: float) -> None:
    kept = store_setting(request.command, request.data, module.memory.baud_code, module.setup)
    module.memory.baud_code = kept.value
    how = module.setup.baud_ack
    if how is BaudChange.NEW:
        module.baud_rate = module.memory.baud_rate
    reply(module, request.command.code, kept.acknowledgement, now_s)
    if how is BaudChange.OLD:
        module.baud_rate = module.memory.baud_rate


def _zero(module: Hardware, request: Request, now_s: float) -> None:
    if module.setup.keeps:
        module.memory.zero_tilt_deg = module.world.motion(now_s).tilt_deg
    reply(module, request.command.code, ACCEPTED, now_s)


def _status(module: Hardware, _request: Request, now_s: float) -> None:
    module.advance(now_s)
    module.send(module.status(now_s), now_s)


def _cell_voltage(module: Hardware, _request: Request, now_s: float) -> None:
    module.advance(now_s)
    reply(module, module.setup.voltage_code, module.voltage(now_s), now_s)


def _trigger_records(module: Hardware, _request: Request, now_s: float) -> None:
    module.advance(now_s)
    frames = [record_frame(data) for data in module.memory.records]
    fill = {EmptySlots.ZEROS: b"\x00", EmptySlots.ONES: b"\xff"}.get(module.setup.empty_slots)
    if fill is not None:
        frames += [record_frame(fill * RECORD_DATA_LENGTH)] * (MAX_RECORDS - len(frames))
    together = b"".join(frames)
    delivery = module.setup.records
    if delivery is Delivery.PIECES:
        frames = [together[at : at + PIECE_LENGTH] for at in range(0, len(together), PIECE_LENGTH)]
    elif delivery is Delivery.TOGETHER:
        frames = [together] if together else []
    for position, frame in enumerate(frames):
        module.send(frame, now_s + position * RECORD_GAP_S)
    if delivery is Delivery.PIECES and frames:
        module.hold_stream(now_s + len(frames) * RECORD_GAP_S)


_ANSWERS: dict[str, Answer] = {
    "heartbeat": _heartbeat,
    "activation": _activation,
    "deploy": _deploy,
    "shutdown": _shutdown,
    "serial_output": _serial_output,
    "light": _value(lambda module, now_s: module.light(now_s)),
    "light_threshold": _setting("light_threshold"),
    "attitude_trigger": _flag("attitude_is_enabled", INVERTED),
    "freefall_trigger": _flag("freefall_is_enabled", INVERTED),
    "attitude_threshold": _setting("attitude_threshold"),
    "freefall_acceleration": _setting("freefall_acceleration"),
    "freefall_time": _setting("freefall_time"),
    "boot_count": _value(lambda module, _now_s: module.memory.boot_count),
    "baud_rate": _baud_rate,
    "zero_sensor": _zero,
    "active": _value(lambda module, now_s: int(module.reports_active(now_s))),
    "triggered": _value(lambda module, _now_s: int(module.is_triggered)),
    "status": _status,
    "charging": _value(lambda module, _now_s: int(module.world.has_external_power)),
    "cell_voltage": _cell_voltage,
    "trigger_records": _trigger_records,
}


BROKEN_OFF_S = 0.1
"""After this much silence, a part of a frame is discarded."""


class SimulatedModule(Hardware):
    _heard = b""
    _last_byte_s = -math.inf

    def _clear(self) -> None:
        super()._clear()
        self._heard, self._last_byte_s = b"", -math.inf

    def receive(self, data: bytes, now_s: float) -> list[SentBytes]:
        """Takes bytes from the host; returns what is sent by now."""
        sent = self.collect(now_s)
        if not self.is_on:
            return sent
        for request in self._requests(data, now_s):
            if self.is_on:
                self.heard_s = now_s
                self.obey(request, now_s)
        return sent + self.collect(now_s)

    def obey(self, request: Request, now_s: float) -> None:
        """Carry out a request and queue the reply, unless it ignores the command."""
        if request.command.code not in self.setup.mute_codes:
            answer(self, request, now_s)

    def _requests(self, data: bytes, now_s: float) -> list[Request]:
        """The valid host frames that `data` completes; other bytes are skipped."""
        if now_s - self._last_byte_s > BROKEN_OFF_S:
            self._heard = b""
        self._last_byte_s = now_s
        requests, self._heard = requests_in(self._heard + data)
        return requests
