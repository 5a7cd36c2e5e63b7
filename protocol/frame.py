"""Encodes and validates a single frame.

    host to module      42 61 | code | control | data | sum          six bytes, always
    module to host      41 75 | code | 01 | value | sum              six bytes
                        41 75 | 01 | A5 | 5A | 00                    heartbeat, six bytes
                        41 75 | 32 | tilt | acc | trig | act | sum   status, eight bytes
                        41 75 | 35 | 01 | eleven bytes | sum         trigger record, sixteen bytes

The sum is the low byte of the sum of everything between header and sum (E13: also in the long frames). It detects
every one-bit and every one-byte error, and misses about 6 % of two-bit errors. So the code, the control byte and the
value must also be ones that the table allows.
"""

from collections.abc import Callable, Mapping
from enum import Enum
from functools import cache
from types import MappingProxyType
from typing import NamedTuple

from protocol.catalogue import (
    BY_CODE,
    COMMANDS,
    HEARTBEAT_CODE,
    HOST_HEADER,
    MODULE_HEADER,
    QUERY,
    RECORD_CODE,
    RECORD_PART,
    SET,
    STATUS_CODE,
    Command,
    Layout,
    Request,
)
from protocol.translatable import marked

HOST_FRAME_LENGTH = 6
MAX_FRAME_LENGTH = Layout.RECORD.value


class Direction(Enum):
    HOST_TO_MODULE = "host_to_module"
    MODULE_TO_HOST = "module_to_host"


class Reason(Enum):
    """Why bytes are not a frame; the keys of the rejected-byte counters."""

    NO_HEADER = "no_header"
    UNKNOWN_CODE = "unknown_code"
    CONTROL = "control"
    CHECKSUM = "checksum"
    VALUE = "value"
    INCOMPLETE = "incomplete"


class Frame(NamedTuple):
    """One whole, valid frame. `raw` holds all of its bytes; `offset` counts from the first byte ever fed.

    A named tuple, not a dataclass: up to 1,440 a second are made, and making one takes a quarter of the time.
    """

    direction: Direction
    raw: bytes
    offset: int = 0


class Fault(NamedTuple):
    """What is wrong with bytes that begin like a frame: English, translatable, with the wrong bytes in hex."""

    reason: Reason
    text: str
    values: Mapping[str, str] = MappingProxyType({})
    """The placeholders of `text`."""

    @property
    def detail(self) -> str:
        """The whole sentence in English."""
        return self.text.format(**self.values)


class Noise(NamedTuple):
    """Consecutive bytes that are not a frame, and why."""

    raw: bytes
    fault: Fault
    offset: int

    @property
    def reason(self) -> Reason:
        return self.fault.reason

    @property
    def detail(self) -> str:
        return self.fault.detail


def checksum(body: bytes) -> int:
    """Low byte of the sum of `body` (code up to the last data byte)."""
    return sum(body) & 0xFF


def encode_reply(code: int, value: int) -> bytes:
    """A six-byte module frame: 41 75 code 01 value sum."""
    return encode_long(code, bytes((QUERY, value)))


def encode_long(code: int, data: bytes) -> bytes:
    """A status (code 32, four bytes) or a record (code 35, 01 and eleven bytes)."""
    body = bytes((code,)) + data
    return MODULE_HEADER + body + bytes((checksum(body),))


def _short_values() -> dict[int, frozenset[int]]:
    """Values of D4 in a six-byte module frame, by code; a code may answer several commands (E3, E4)."""
    values: dict[int, frozenset[int]] = {}
    for command in COMMANDS:
        if command.reply is not None:
            for code in command.reply_codes:
                values[code] = values.get(code, frozenset()) | command.reply.allowed
    return values


def _host_form(command: Command) -> dict[int, frozenset[int]]:
    form: dict[int, frozenset[int]] = {}
    if command.query_data is not None:
        form[command.query().control] = frozenset((command.query_data,))
    if command.write is not None:
        form[SET] = command.write.allowed
    return form


SHORT_VALUES = _short_values()
HOST_FORMS = {command.code: _host_form(command) for command in COMMANDS}
"""Control byte -> values of D4 in a host frame, by code."""
_HEARTBEAT_BODY = bytes((0xA5, 0x5A))


def _sum_fault(raw: bytes) -> Fault | None:
    expected = checksum(raw[2:-1])
    if raw[-1] == expected:
        return None
    values = {"found": f"{raw[-1]:02X}", "expected": f"{expected:02X}"}
    return Fault(Reason.CHECKSUM, marked("checksum {found}, the sum is {expected}"), values)


@cache
def unknown_code(code: int) -> Fault:
    return Fault(Reason.UNKNOWN_CODE, marked("unknown command code {code}"), {"code": f"{code:02X}"})


@cache
def wrong_control(control: int) -> Fault:
    """A module frame whose control byte is not 01."""
    return Fault(Reason.CONTROL, marked("control byte {control}, expected 01"), {"control": f"{control:02X}"})


def _wrong_value(raw: bytes) -> Fault:
    values = {"value": f"{raw[4]:02X}", "code": f"{raw[2]:02X}"}
    return Fault(Reason.VALUE, marked("value {value} is not allowed for {code}"), values)


def _flag_fault(*flags: int) -> Fault | None:
    text = marked("flag {value}, expected 00 or 01")
    return next((Fault(Reason.VALUE, text, {"value": f"{flag:02X}"}) for flag in flags if flag > 1), None)


def _check_status(raw: bytes) -> Fault | None:
    return _sum_fault(raw) or _flag_fault(raw[5], raw[6])


def is_empty_slot(raw: bytes) -> bool:
    """A record slot that was never used: all data 00 or all FF (E7)."""
    data = raw[4:-1]
    return data == bytes(len(data)) or data == b"\xff" * len(data)


def _check_record(raw: bytes) -> Fault | None:
    if raw[3] != QUERY:
        return wrong_control(raw[3])
    fault = _sum_fault(raw)
    if fault is not None or is_empty_slot(raw):
        return fault
    return _flag_fault(*(RECORD_PART[name].raw(raw) for name in ("serial_connected", "charging")))


def _check_short(raw: bytes) -> Fault | None:
    code = raw[2]
    if code == HEARTBEAT_CODE:
        if raw[3:5] != _HEARTBEAT_BODY:
            values = {"found": raw[3:5].hex(" ").upper()}
            return Fault(Reason.VALUE, marked("heartbeat carries {found}, expected A5 5A"), values)
        return _sum_fault(raw)
    if raw[3] != QUERY:
        return wrong_control(raw[3])
    return _sum_fault(raw) or (None if raw[4] in SHORT_VALUES[code] else _wrong_value(raw))


def check_host(raw: bytes) -> Fault | None:
    """What is wrong with these six bytes as a host frame, or None. The header is not checked."""
    forms = HOST_FORMS.get(raw[2])
    if forms is None:
        return unknown_code(raw[2])
    values = forms.get(raw[3])
    if values is None:
        names = {"control": f"{raw[3]:02X}", "code": f"{raw[2]:02X}"}
        return Fault(Reason.CONTROL, marked("control byte {control} does not go with command {code}"), names)
    return _sum_fault(raw) or (None if raw[4] in values else _wrong_value(raw))


MODULE_CHECKS: Mapping[int, Callable[[bytes], Fault | None]] = {
    Layout.SHORT.value: _check_short, Layout.STATUS.value: _check_status, Layout.RECORD.value: _check_record,
}  # fmt: skip
"""By length: the check of a module frame, which has a known code; the header is not checked."""


def module_lengths(code: int) -> tuple[int, ...]:
    """The lengths that a module frame of this code may have; none for an unknown code.

    Code 35 has two (E3): a record has 16 bytes, a cell voltage answered with code 35 has six.
    """
    if code == RECORD_CODE:
        return (Layout.RECORD.value, Layout.SHORT.value)
    if code == STATUS_CODE:
        return (Layout.STATUS.value,)
    return (Layout.SHORT.value,) if code in BY_CODE else ()


def decode_request(raw: bytes) -> Request:
    """Return the request in a valid host frame; raise `ValueError` for anything else."""
    if len(raw) != HOST_FRAME_LENGTH or raw[:2] != HOST_HEADER:
        raise ValueError(f"{raw.hex(' ')} is no host frame")
    fault = check_host(raw)
    if fault is not None:
        raise ValueError(fault.detail)
    return Request(BY_CODE[raw[2]], raw[3], raw[4])


def requests_in(heard: bytes) -> tuple[list[Request], bytes]:
    """The valid host frames in these bytes, and the rest, which may begin another one; other bytes are skipped."""
    requests: list[Request] = []
    position = 0
    while (start := heard.find(HOST_HEADER, position)) >= 0 and len(heard) - start >= HOST_FRAME_LENGTH:
        raw = heard[start : start + HOST_FRAME_LENGTH]
        if check_host(raw) is None:
            requests.append(decode_request(raw))
            position = start + HOST_FRAME_LENGTH
        else:
            position = start + 1
    return requests, heard[start:] if start >= 0 else heard[position:][-1:]
