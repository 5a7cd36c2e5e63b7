"""Simulated module: bytes and time in, bytes out, as the vendor's table says.

    power_on -> two heartbeats 50 ms apart -> answers, streams while serial output is on -> shut_down -> silence

No clock and no thread: every method takes `now_s`, seconds of one monotonic clock. The sensor is evaluated 200 times a
second, also afterwards, up to `MAX_WATCH_S` back.

Where the table does not tell, this module: answers `11 01` with 00 while it is locked, and does not fire; ends
"triggered" at the reset angle after an attitude trigger, and with `10 00`, `11 00` or a restart after others; blocks
all triggers from `11 00` until `11 01`, `10` or a restart; sends all nine slots at once, the oldest record first, and
00 in those that were never used; acknowledges a new baud rate at the old one; does not answer invalid frames.
"""

import math
from collections.abc import Callable

from app.simulator.hardware import Hardware, SentBytes
from app.simulator.memory import RECORD_DATA_LENGTH, record_frame
from protocol.catalogue import CELL_VOLTAGE, FLAG, HEARTBEAT_REPLY, INVERTED, MAX_RECORDS, RECORD_CODE, Request
from protocol.fields import Flag
from protocol.frame import encode_reply, requests_in
from protocol.messages import Source

ACCEPTED = 0x01
FREEFALL_CODE = 0x16
"""E4: the table prints the acknowledgement of 17 with code 16."""
BROKEN_OFF_S = 0.1
"""After this much silence, a part of a frame is discarded."""

Answer = Callable[[Hardware, Request, float], None]


def reply(module: Hardware, code: int, value: int, now_s: float) -> None:
    module.send(encode_reply(code, value), now_s)


def _value(read: Callable[[Hardware, float], int]) -> Answer:
    """Answer of a command that reports one byte."""

    def report(module: Hardware, request: Request, now_s: float) -> None:
        module.advance(now_s)
        # E3: the table prints the answer to 34 with code 35.
        code = RECORD_CODE if request.command is CELL_VOLTAGE else request.command.code
        reply(module, code, read(module, now_s), now_s)

    return report


def _setting(attribute: str) -> Answer:
    """Answer of a setting in the memory that can be queried and set."""

    def ask_or_set(module: Hardware, request: Request, now_s: float) -> None:
        if request.is_set:
            setattr(module.memory, attribute, request.data)
        reply(module, request.command.code, getattr(module.memory, attribute), now_s)

    return ask_or_set


def _flag(attribute: str, field: Flag) -> Answer:
    """Answer of a flag that can be set but not queried (E8)."""

    def set_flag(module: Hardware, request: Request, now_s: float) -> None:
        setattr(module.state, attribute, request.data == field.true)
        code = FREEFALL_CODE if request.command.code == 0x17 else request.command.code
        reply(module, code, request.data, now_s)

    return set_flag


def _heartbeat(module: Hardware, _request: Request, now_s: float) -> None:
    module.send(HEARTBEAT_REPLY, now_s)


def _activation(module: Hardware, request: Request, now_s: float) -> None:
    module.activate(is_active=request.data == FLAG.true)
    reply(module, request.command.code, request.data, now_s)


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
    module.state.serial_output_is_on = request.data == FLAG.true
    reply(module, request.command.code, request.data, now_s)
    if module.state.serial_output_is_on:
        module.start_stream(now_s)
    else:
        module.stop_stream()


def _baud_rate(module: Hardware, request: Request, now_s: float) -> None:
    module.memory.baud_code = request.data
    reply(module, request.command.code, request.data, now_s)
    module.baud_rate = module.memory.baud_rate


def _zero(module: Hardware, request: Request, now_s: float) -> None:
    module.memory.zero_tilt_deg = module.world.motion(now_s).tilt_deg
    reply(module, request.command.code, ACCEPTED, now_s)


def _status(module: Hardware, _request: Request, now_s: float) -> None:
    module.advance(now_s)
    module.send(module.status(now_s), now_s)


def _trigger_records(module: Hardware, _request: Request, now_s: float) -> None:
    module.advance(now_s)
    frames = [record_frame(data) for data in module.memory.records]
    frames += [record_frame(bytes(RECORD_DATA_LENGTH))] * (MAX_RECORDS - len(frames))
    module.send(b"".join(frames), now_s)


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
    "cell_voltage": _value(lambda module, now_s: module.voltage(now_s)),
    "trigger_records": _trigger_records,
}


class SimulatedModule(Hardware):
    _heard = b""
    _last_byte_s = -math.inf

    def _clear(self) -> None:
        super()._clear()
        self._heard = b""
        self._last_byte_s = -math.inf

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
        """Carry out a request and queue the reply."""
        _ANSWERS[request.command.name](self, request, now_s)

    def _requests(self, data: bytes, now_s: float) -> list[Request]:
        """The valid host frames that `data` completes; other bytes are skipped."""
        if now_s - self._last_byte_s > BROKEN_OFF_S:
            self._heard = b""
        self._last_byte_s = now_s
        requests, self._heard = requests_in(self._heard + data)
        return requests
