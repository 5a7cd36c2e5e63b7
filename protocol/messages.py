"""Decoded module frames: frozen, typed, with the unit in each name.

The meaning of a frame depends on the request: a six-byte 35 is a cell voltage if that was asked for (E3), a 16 may
answer a set of 17 (E4), D4 = 01 after a set may be "understood" instead of a value (E2).
"""

from collections.abc import Mapping
from enum import Flag as BitFlag
from typing import Any, NamedTuple

from protocol.catalogue import (
    BY_CODE,
    CELL_VOLTAGE,
    DEGREE,
    FLAG,
    HEARTBEAT_CODE,
    RECORD_CODE,
    RECORD_PARTS,
    STATUS_CODE,
    TENTH_G,
    Command,
    Layout,
    Request,
)
from protocol.fields import Value
from protocol.frame import encode_long, is_empty_slot

HIGHEST_CELL_V = 4.2  # a full lithium cell; the table's own example says D2 = 4.2 V (E12)
LOWEST_CELL_V = 2.5  # a lithium cell below this is destroyed and cannot have supplied the module


class Heartbeat:
    """Code 01: the module is present."""

    def __repr__(self) -> str:
        return "Heartbeat()"


class Reading(NamedTuple):
    """The value that a command's six-byte reply carries. `raw` is D4."""

    command: Command
    raw: int

    @property
    def value(self) -> Value:
        """In the unit of the command's field. Raises `LookupError` for a command whose reply carries none."""
        if self.command.reply is None:
            raise LookupError(f"the reply to {self.command.name} carries no value")
        return self.command.reply.decode(self.raw)


class Acknowledgement(NamedTuple):
    """The reply to a set, or to the act that has the form of a query (25): "received", which proves no value (E2)."""

    request: Request
    raw: int

    @property
    def is_echo(self) -> bool:
        """The module repeated the value that was sent."""
        return self.raw == self.request.data

    @property
    def is_accepted(self) -> bool:
        """The value itself, or 01 where the table says that 01 means success (E2, and 25, which sends no value)."""
        is_by_one = self.request.command.acknowledged_by_one or not self.request.is_set
        return self.is_echo or (is_by_one and self.raw == 0x01)


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
    """The sixteen bytes of a valid record frame."""
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
