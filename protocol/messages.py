"""Frames, and what those of the module mean: typed, with the unit in each name.

    host to module      42 61 | code | control | data | sum          six bytes, always
    module to host      41 75 | code | 01 | value | sum              six bytes
                        41 75 | 01 | A5 | 5A | 00                    heartbeat, six bytes
                        41 75 | 32 | tilt | acc | trig | act | sum   status, eight bytes
                        41 75 | 35 | 01 | eleven bytes | sum         trigger record, sixteen bytes

The sum is the low byte of the sum of everything between header and sum (E13: also in the long frames). It detects
every one-bit and every one-byte error, and misses about 6 % of two-bit errors. So the code, the control byte and the
value must also be ones that the table allows.

The meaning of a frame depends on the request: a six-byte 35 is a cell voltage if that was asked for (E3), a 16 may
answer a set of 17 (E4), D4 = 01 after a set may be "understood" instead of a value (E2).
"""

from collections.abc import Mapping
from enum import Enum
from enum import Flag as BitFlag
from typing import Any, NamedTuple

from protocol.catalogue import (
    BY_CODE,
    CELL_VOLTAGE,
    COMMANDS,
    DEGREE,
    FLAG,
    HEARTBEAT_CODE,
    HEARTBEAT_REPLY,
    HOST_HEADER,
    MODULE_HEADER,
    QUERY,
    RECORD_CODE,
    RECORD_PART,
    RECORD_PARTS,
    SET,
    STATUS_CODE,
    TENTH_G,
    Command,
    Layout,
    Request,
)
from protocol.fields import Value
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
    return sum(body) & 0xFF


def encode_reply(code: int, value: int) -> bytes:
    """A six-byte module frame: 41 75 code 01 value sum."""
    return encode_long(code, bytes((QUERY, value)))


def encode_long(code: int, data: bytes) -> bytes:
    """A status (code 32, four bytes) or a record (code 35, 01 and eleven bytes)."""
    body = bytes((code,)) + data
    return MODULE_HEADER + body + bytes((checksum(body),))


# Values of D4 in a six-byte module frame, by code; a code may answer several commands (E3, E4).
_SHORT_VALUES: dict[int, frozenset[int]] = {}
# Values of D4 in a host frame, by code and control byte.
_HOST_VALUES: dict[tuple[int, int], frozenset[int]] = {}
for _command in COMMANDS:
    if _command.reply is not None:
        for _code in _command.reply_codes:
            _SHORT_VALUES[_code] = _SHORT_VALUES.get(_code, frozenset()) | _command.reply.allowed
    if _command.query_data is not None:
        _HOST_VALUES[_command.code, _command.query().control] = frozenset((_command.query_data,))
    if _command.write is not None:
        _HOST_VALUES[_command.code, SET] = _command.write.allowed


def is_empty_slot(raw: bytes) -> bool:
    """A record slot that was never used: all data 00 or all FF (E7)."""
    data = raw[4:-1]
    return data == bytes(len(data)) or data == b"\xff" * len(data)


def check_module(raw: bytes) -> Reason | None:
    """Say what is wrong with these bytes as a module frame; None if nothing is. They have a known code and one of its
    lengths; the header is not checked."""
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
    if raw[-1] != checksum(raw[2:-1]):
        return Reason.CHECKSUM
    return None if is_allowed else Reason.VALUE


def check_host(raw: bytes) -> Reason | None:
    """Say what is wrong with these six bytes as a host frame; None if nothing is. The header is not checked."""
    if raw[2] not in BY_CODE:
        return Reason.UNKNOWN_CODE
    allowed = _HOST_VALUES.get((raw[2], raw[3]))
    if allowed is None:
        return Reason.CONTROL
    if raw[-1] != checksum(raw[2:-1]):
        return Reason.CHECKSUM
    return None if raw[4] in allowed else Reason.VALUE


def decode_request(raw: bytes) -> Request:
    """Return the request in a valid host frame; raise `ValueError` for anything else."""
    is_framed = len(raw) == HOST_FRAME_LENGTH and raw[:2] == HOST_HEADER
    wrong = check_host(raw) if is_framed else Reason.NO_HEADER
    if wrong is not None:
        raise ValueError(f"{raw.hex(' ')}: {wrong.value}")
    return Request(BY_CODE[raw[2]], raw[3], raw[4])


HIGHEST_CELL_V = 4.2  # a full lithium cell; the table's own example says D2 = 4.2 V (E12)
LOWEST_CELL_V = 2.5  # a lithium cell below this is destroyed and cannot have supplied the module


class Heartbeat:
    def __repr__(self) -> str:
        return "Heartbeat()"


class Reading(NamedTuple):
    """The value that a command's six-byte reply carries. `raw` is D4."""

    command: Command
    raw: int

    @property
    def value(self) -> Value:
        """The value in the unit of the command's field. Raises `LookupError` for a command whose reply carries none."""
        if self.command.reply is None:
            raise LookupError(f"the reply to {self.command.name} carries no value")
        return self.command.reply.decode(self.raw)


class Acknowledgement(NamedTuple):
    """The reply to a set, or to the act that has the form of a query (25): "received", which proves no value (E2)."""

    request: Request
    raw: int

    @property
    def is_accepted(self) -> bool:
        """The value itself, or 01 where the table says that 01 means success (E2, and 25, which sends no value)."""
        is_by_one = self.request.command.acknowledged_by_one or not self.request.is_set
        return self.raw == self.request.data or (is_by_one and self.raw == 0x01)


class Status(NamedTuple):
    """Code 32: `41 75 32 tilt acc trig act sum`. Also what is streamed."""

    tilt_deg: int  # angle to the horizontal plane, whole degrees, 0 … 255
    acceleration_g: float  # magnitude, 0.0 … 25.5 g in steps of 0.1
    triggered: bool
    active: bool

    def encode(self) -> bytes:
        data = (
            DEGREE.encode(self.tilt_deg),
            TENTH_G.encode(self.acceleration_g),
            FLAG.encode(self.triggered),
            FLAG.encode(self.active),
        )
        return encode_long(STATUS_CODE, bytes(data))


class Source(BitFlag):
    """The cause of a trigger (D7). Bits may be combined; the table does not know the upper four."""

    SERIAL = 0x01
    ATTITUDE = 0x02
    PWM = 0x04
    FREEFALL = 0x08
    BIT4 = 0x10
    BIT5 = 0x20
    BIT6 = 0x40
    BIT7 = 0x80


class TriggerRecord(NamedTuple):
    """Code 35, sixteen bytes: a trigger and the module's state at that time; layout in `RECORD_PARTS`."""

    boot_count: int
    uptime_s: int
    sources: tuple[str, ...]  # names from `Source`, lower case, lowest bit first
    attitude_threshold_deg: int
    freefall_acceleration_g: float
    freefall_time_s: float
    serial_connected: bool
    charging: bool  # 00 is charging, the opposite of command 33
    light_v: float  # the light at the trigger; the example's caption "threshold" is wrong (E14)
    cell_voltage_v: float
    raw: bytes

    @property
    def implausible(self) -> tuple[str, ...]:
        """Names of the values that are impossible for a lithium cell without external power (E12)."""
        in_range = LOWEST_CELL_V <= self.cell_voltage_v <= HIGHEST_CELL_V
        return () if in_range or self.charging else ("cell_voltage_v",)


class EmptySlot(NamedTuple):
    """A record slot that was never used: all 00 or all FF (E7). Not a trigger."""

    raw: bytes


Message = Heartbeat | Reading | Acknowledgement | Status | TriggerRecord | EmptySlot


def decode_record(raw: bytes) -> TriggerRecord | EmptySlot:
    if is_empty_slot(raw):
        return EmptySlot(raw)
    values: dict[str, Any] = {part.name: part.field.decode(part.raw(raw)) for part in RECORD_PARTS}
    values["sources"] = tuple((source.name or "").lower() for source in Source if values["sources"] & source.value)
    return TriggerRecord(**values, raw=raw)


def encode_record_data(raws: Mapping[str, int]) -> bytes:
    """The eleven data bytes of a record (D4 … D14) from its raw values by name."""
    return b"".join(raws[part.name].to_bytes(part.length, "big") for part in RECORD_PARTS)


def decode(raw: bytes, asked: Request | None = None) -> Message:
    """Decode a valid module frame, as the answer to `asked` where it can be one (`answers`)."""
    code = raw[2]
    if code == HEARTBEAT_CODE:
        return Heartbeat()
    if code == STATUS_CODE:
        return Status(raw[3], raw[4] / TENTH_G.per_unit, raw[5] == 0x01, raw[6] == 0x01)
    if len(raw) == Layout.RECORD.value:
        return decode_record(raw)
    if asked is not None and answers(raw, asked):
        if asked.is_repeatable:
            return Reading(asked.command, raw[4])
        return Acknowledgement(asked, raw[4])
    return Reading(CELL_VOLTAGE if code == RECORD_CODE else BY_CODE[code], raw[4])


def answers(raw: bytes, asked: Request) -> bool:
    """Whether a valid module frame can be the answer to `asked`: by code, by length and by allowed value."""
    command = asked.command
    if raw[2] not in command.reply_codes or len(raw) != command.layout.value:
        return False
    if command.reply is None or asked.is_set:
        return True
    return raw[4] in command.reply.allowed
