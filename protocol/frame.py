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

from collections.abc import Mapping
from enum import Enum
from types import MappingProxyType
from typing import NamedTuple

from protocol.catalogue import (
    BY_CODE,
    COMMANDS,
    HEARTBEAT_CODE,
    HEARTBEAT_REPLY,
    HOST_HEADER,
    MODULE_HEADER,
    QUERY,
    RECORD_CODE,
    RECORD_PART,
    SET,
    STATUS_CODE,
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
    values: Mapping[str, str] = MappingProxyType({})  # the placeholders of `text`

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


def _host_values() -> dict[tuple[int, int], frozenset[int]]:
    """Values of D4 in a host frame, by code and control byte."""
    values: dict[tuple[int, int], frozenset[int]] = {}
    for command in COMMANDS:
        if command.query_data is not None:
            values[command.code, command.query().control] = frozenset((command.query_data,))
        if command.write is not None:
            values[command.code, SET] = command.write.allowed
    return values


_SHORT_VALUES = _short_values()
_HOST_VALUES = _host_values()


def fault(reason: Reason, text: str, **wrong: int) -> Fault:
    return Fault(reason, text, {name: f"{byte:02X}" for name, byte in wrong.items()})


def unknown_code(code: int) -> Fault:
    return fault(Reason.UNKNOWN_CODE, marked("unknown command code {code}"), code=code)


def wrong_control(control: int) -> Fault:
    """A module frame whose control byte is not 01."""
    return fault(Reason.CONTROL, marked("control byte {control}, expected 01"), control=control)


def _sum_fault(raw: bytes) -> Fault | None:
    expected = checksum(raw[2:-1])
    if raw[-1] == expected:
        return None
    return fault(Reason.CHECKSUM, marked("checksum {found}, the sum is {expected}"), found=raw[-1], expected=expected)


def _value_fault(raw: bytes, allowed: frozenset[int]) -> Fault | None:
    if raw[4] in allowed:
        return None
    return fault(Reason.VALUE, marked("value {value} is not allowed for {code}"), value=raw[4], code=raw[2])


def _flag_fault(*flags: int) -> Fault | None:
    text = marked("flag {value}, expected 00 or 01")
    return next((fault(Reason.VALUE, text, value=flag) for flag in flags if flag > 1), None)


def is_empty_slot(raw: bytes) -> bool:
    """A record slot that was never used: all data 00 or all FF (E7)."""
    data = raw[4:-1]
    return data == bytes(len(data)) or data == b"\xff" * len(data)


def check_module(raw: bytes) -> Fault | None:
    """What is wrong with these bytes as a module frame, or None. They have a known code and one of its lengths; the
    header is not checked."""
    code = raw[2]
    if len(raw) == Layout.STATUS.value:
        return _sum_fault(raw) or _flag_fault(raw[5], raw[6])
    if code == HEARTBEAT_CODE:
        if raw[3:5] == HEARTBEAT_REPLY[3:5]:
            return _sum_fault(raw)
        text = marked("heartbeat carries {found}, expected A5 5A")
        return Fault(Reason.VALUE, text, {"found": raw[3:5].hex(" ").upper()})
    if raw[3] != QUERY:
        return wrong_control(raw[3])
    if len(raw) == Layout.SHORT.value:
        return _sum_fault(raw) or _value_fault(raw, _SHORT_VALUES[code])
    flags = (RECORD_PART[name].raw(raw) for name in ("serial_connected", "charging"))
    return _sum_fault(raw) or (None if is_empty_slot(raw) else _flag_fault(*flags))


def check_host(raw: bytes) -> Fault | None:
    """What is wrong with these six bytes as a host frame, or None. The header is not checked."""
    code, control = raw[2], raw[3]
    if code not in BY_CODE:
        return unknown_code(code)
    allowed = _HOST_VALUES.get((code, control))
    if allowed is None:
        text = marked("control byte {control} does not go with command {code}")
        return fault(Reason.CONTROL, text, control=control, code=code)
    return _sum_fault(raw) or _value_fault(raw, allowed)


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
    wrong = check_host(raw)
    if wrong is not None:
        raise ValueError(wrong.detail)
    return Request(BY_CODE[raw[2]], raw[3], raw[4])
