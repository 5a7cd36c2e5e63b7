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

from enum import Enum
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
    """Why bytes are not a frame: English, translatable."""

    NO_HEADER = marked("no frame header")
    UNKNOWN_CODE = marked("unknown code")
    CONTROL = marked("wrong control byte")
    CHECKSUM = marked("wrong checksum")
    VALUE = marked("impossible value")
    INCOMPLETE = marked("broken off")


class Frame(NamedTuple):
    """One whole, valid frame. `raw` holds all of its bytes; `offset` counts from the first byte ever fed.

    A named tuple, not a dataclass: up to 1,440 a second are made, and making one takes a quarter of the time.
    """

    direction: Direction
    raw: bytes
    offset: int = 0


class Noise(NamedTuple):
    """Consecutive bytes that are not a frame, and why."""

    raw: bytes
    reason: Reason
    offset: int


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


def _wrong_sum(raw: bytes) -> Reason | None:
    return None if raw[-1] == checksum(raw[2:-1]) else Reason.CHECKSUM


def is_empty_slot(raw: bytes) -> bool:
    """A record slot that was never used: all data 00 or all FF (E7)."""
    data = raw[4:-1]
    return data == bytes(len(data)) or data == b"\xff" * len(data)


def check_module(raw: bytes) -> Reason | None:
    """What is wrong with these bytes as a module frame, or None. They have a known code and one of its lengths; the
    header is not checked."""
    code = raw[2]
    is_allowed = True
    if len(raw) == Layout.STATUS.value:
        is_allowed = max(raw[5], raw[6]) <= 1
    elif code == HEARTBEAT_CODE:
        is_allowed = raw[3:5] == HEARTBEAT_REPLY[3:5]
    elif raw[3] != QUERY:
        return Reason.CONTROL
    elif len(raw) == Layout.SHORT.value:
        is_allowed = raw[4] in _SHORT_VALUES[code]
    elif not is_empty_slot(raw):
        is_allowed = all(RECORD_PART[name].raw(raw) <= 1 for name in ("serial_connected", "charging"))
    return _wrong_sum(raw) or (None if is_allowed else Reason.VALUE)


def check_host(raw: bytes) -> Reason | None:
    """What is wrong with these six bytes as a host frame, or None. The header is not checked."""
    if raw[2] not in BY_CODE:
        return Reason.UNKNOWN_CODE
    allowed = _HOST_VALUES.get((raw[2], raw[3]))
    if allowed is None:
        return Reason.CONTROL
    return _wrong_sum(raw) or (None if raw[4] in allowed else Reason.VALUE)


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
        raise ValueError(f"{raw.hex(' ')}: {wrong.value}")
    return Request(BY_CODE[raw[2]], raw[3], raw[4])
