"""Reads telemetry as ground stations keep it (`.tlog`): MAVLink 1 and 2, each message behind the time of its arrival.

Attitude, acceleration of every sensor, altitude, arming, landing. Times are the vehicle's own. Each message has a
checksum, so damage costs the damaged messages.
"""

import struct
from array import array
from binascii import crc_hqx
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from app.flights.flight_log import Floats, unreadable
from app.flights.raw_log import (
    STANDARD_GRAVITY_M_S2,
    Channel,
    FlagChannel,
    RawLog,
    force_of_axes,
    tilt_of_quaternion,
    tilt_of_roll_and_pitch,
)
from app.flights.records import RecordField, RecordTable, read_bytes
from app.text.messages import message
from protocol.translatable import marked

_STAMP: Final = struct.Struct(">Q")
"""Microseconds since 1970, before each message."""
_STAMPS_US: Final = (946_684_800_000_000, 4_102_444_800_000_000)
"""The years 2000 to 2100."""
_HEADS: Final = {0xFE: 6, 0xFD: 10}
"""Bytes before the payload in MAVLink 1 and 2, by the first of them."""
_SIGNED: Final = 0x01
_SIGNATURE_BYTES: Final = 13
_CHECKSUM_BYTES: Final = 2
_AUTOPILOT: Final = 1
"""The component that flies; gimbals and cameras have attitudes, too."""
_ARMED: Final = 0x80
_ON_GROUND: Final = 1
_REVERSED: Final = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))
_BOOT_MS: Final = RecordField(0, "<u4", 1e-3)
_SINCE_US: Final = RecordField(0, "<u8", 1e-6)
_LATEST_S: Final = 1e8
"""A later vehicle's time counts from 1970, and has nothing to do with the others."""


class _Kind(NamedTuple):
    """A message: what its checksum ends with, and its fields, with their place in the payload."""

    name: str
    checksum_end: int
    size: int
    fields: Mapping[str, RecordField]


def _milli_g(offset: int) -> dict[str, RecordField]:
    return {axis: RecordField(offset + 2 * number, "<i2", 1e-3) for number, axis in enumerate("xyz")}


_SCALED: Final = {"time": _BOOT_MS, **_milli_g(4)}
_KINDS: Final[Mapping[int, _Kind]] = {
    0: _Kind("HEARTBEAT", 50, 9, {"mode": RecordField(6, "<u1")}),
    26: _Kind("SCALED_IMU", 170, 22, _SCALED),
    27: _Kind("RAW_IMU", 144, 26, {"time": _SINCE_US, **_milli_g(8)}),
    30: _Kind("ATTITUDE", 39, 28, {
        "time": _BOOT_MS, "roll": RecordField(4, "<f4"), "pitch": RecordField(8, "<f4"),
    }),
    31: _Kind("ATTITUDE_QUATERNION", 246, 32, {
        "time": _BOOT_MS, **{axis: RecordField(4 + 4 * number, "<f4") for number, axis in enumerate("wxyz")},
    }),
    33: _Kind("GLOBAL_POSITION_INT", 104, 28, {"time": _BOOT_MS, "altitude": RecordField(16, "<i4", 1e-3)}),
    105: _Kind("HIGHRES_IMU", 93, 62, {
        "time": _SINCE_US,
        **{axis: RecordField(8 + 4 * number, "<f4", 1 / STANDARD_GRAVITY_M_S2) for number, axis in enumerate("xyz")},
    }),
    116: _Kind("SCALED_IMU2", 76, 22, _SCALED),
    129: _Kind("SCALED_IMU3", 46, 22, _SCALED),
    245: _Kind("EXTENDED_SYS_STATE", 130, 2, {"landed": RecordField(1, "<u1")}),
}  # fmt: skip
_IMUS: Final = ("HIGHRES_IMU", "RAW_IMU", "SCALED_IMU", "SCALED_IMU2", "SCALED_IMU3")
_ATTITUDES: Final = ("ATTITUDE", "ATTITUDE_QUATERNION")


class _Message(NamedTuple):
    stamp_s: float
    system: int
    component: int
    number: int
    payload: bytes


class _Table:
    """All messages of one kind from one vehicle, and when they arrived."""

    def __init__(self, kind: _Kind) -> None:
        self._kind = kind
        self._data = bytearray()
        self._stamps_s = array("d")

    def add(self, found: _Message) -> None:
        # MAVLink 2 leaves out zeros at the end of a payload.
        self._data += found.payload[: self._kind.size].ljust(self._kind.size, b"\0")
        self._stamps_s.append(found.stamp_s)

    @property
    def stamps_s(self) -> Floats:
        return np.frombuffer(self._stamps_s)

    def columns(self, *names: str) -> list[Floats]:
        places = array("q", range(0, len(self._data), self._kind.size))
        table = RecordTable(self._kind.name, bytes(self._data), self._kind.fields, places)
        return [table.column(name) for name in names]


def is_telemetry(start: bytes) -> bool:
    """Whether a file that begins so is telemetry of a ground station."""
    if len(start) < _STAMP.size + 1 or start[_STAMP.size] not in _HEADS:
        return False
    stamp_us = int.from_bytes(start[: _STAMP.size], "big")
    return _STAMPS_US[0] <= stamp_us <= _STAMPS_US[1]


class TelemetryFile:
    """`messages` yields those of `_KINDS`, whose checksums are right."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.skipped_bytes = 0
        self.lost_end_bytes = 0
        """Those of the skipped bytes at the end of the file."""

    def messages(self) -> Iterator[_Message]:
        place, stop = 0, len(self.data)
        while place < stop:
            end = self._end_of_record(place)
            if end is None:
                next_place = self._next_record(place + 1)
                self.skipped_bytes += next_place - place
                if next_place == stop:
                    self.lost_end_bytes = next_place - place
                place = next_place
                continue
            found = self._message(place)
            if found is not None:
                yield found
            place = end

    def _end_of_record(self, place: int) -> int | None:
        """Where the record ends; None where there cannot be one, or where its checksum is wrong."""
        begin = place + _STAMP.size
        data = self.data
        if begin + 2 > len(data) or not is_telemetry(data[place : begin + 1]):
            return None
        head_bytes = _HEADS[data[begin]]
        end = begin + head_bytes + data[begin + 1] + _CHECKSUM_BYTES
        if data[begin] == 0xFD and begin + 2 < len(data) and data[begin + 2] & _SIGNED:
            end += _SIGNATURE_BYTES
        if end > len(data):
            return None
        kind = _KINDS.get(self._number(begin))
        if kind is None:
            # The checksum of a message that nobody asks for is not known: the next one has to be there.
            return end if end == len(data) or is_telemetry(data[end : end + _STAMP.size + 1]) else None
        checked = begin + head_bytes + data[begin + 1]
        (checksum,) = struct.unpack_from("<H", data, checked)
        return end if checksum == x25(data[begin + 1 : checked] + bytes((kind.checksum_end,))) else None

    def _number(self, begin: int) -> int:
        if self.data[begin] == 0xFE:
            return self.data[begin + 5]
        return int.from_bytes(self.data[begin + 7 : begin + 10], "little")

    def _next_record(self, place: int) -> int:
        data = self.data
        while place < len(data):
            begins = [at for at in (data.find(first, place + _STAMP.size) for first in (b"\xfd", b"\xfe")) if at >= 0]
            if not begins:
                return len(data)
            place = min(begins) - _STAMP.size
            if self._end_of_record(place) is not None:
                return place
            place += 1
        return len(data)

    def _message(self, place: int) -> _Message | None:
        begin = place + _STAMP.size
        number = self._number(begin)
        if number not in _KINDS:
            return None
        system_at = begin + (3 if self.data[begin] == 0xFE else 5)
        payload_at = begin + _HEADS[self.data[begin]]
        payload = self.data[payload_at : payload_at + self.data[begin + 1]]
        stamp_s = _STAMP.unpack_from(self.data, place)[0] * 1e-6
        return _Message(stamp_s, self.data[system_at], self.data[system_at + 1], number, payload)


def x25(data: bytes) -> int:
    """MAVLink's checksum: the one of the standard library with the bits of all bytes reversed, which is fast."""
    reversed_bits = crc_hqx(data.translate(_REVERSED), 0xFFFF)
    return _REVERSED[reversed_bits >> 8] | _REVERSED[reversed_bits & 0xFF] << 8


def read_telemetry(path: Path) -> RawLog:
    """Raises `UserError`, OSError."""
    file = TelemetryFile(read_bytes(path))
    found = [one for one in file.messages() if one.component == _AUTOPILOT]
    vehicles = Counter(one.system for one in found if _KINDS[one.number].name in _ATTITUDES)
    if len(vehicles) > 1:
        raise unreadable(marked("more than one vehicle in one file"))
    vehicle = next(iter(vehicles), found[0].system if found else 0)
    tables: dict[str, _Table] = {}
    for one in found:
        if one.system == vehicle:
            kind = _KINDS[one.number]
            tables.setdefault(kind.name, _Table(kind)).add(one)
    raw = RawLog(name=str(path))
    for name in _ATTITUDES:
        if name in tables:
            raw.tilts_deg.append(_attitude(tables[name], name))
    raw.tilts_deg.sort(key=lambda channel: -len(channel.time_s))
    for name in _IMUS:
        if name in tables:
            time_s, *axes_g = tables[name].columns("time", "x", "y", "z")
            if not len(time_s) or float(np.median(time_s)) > _LATEST_S:
                continue
            raw.forces_g.append(Channel(time_s, force_of_axes(*(axis * STANDARD_GRAVITY_M_S2 for axis in axes_g))))
    if "GLOBAL_POSITION_INT" in tables:
        raw.altitude_m = Channel(*tables["GLOBAL_POSITION_INT"].columns("time", "altitude"))
    _read_states(raw, tables)
    if file.skipped_bytes:
        raw.problems.append(message(marked("Damaged; bytes left out: {count}."), count=f"{file.skipped_bytes:,}"))
        raw.lost_end_s = raw.seconds_of(file.lost_end_bytes, len(file.data))
    return raw


def _attitude(table: _Table, name: str) -> Channel:
    if name == "ATTITUDE":
        time_s, roll, pitch = table.columns("time", "roll", "pitch")
        return Channel(time_s, tilt_of_roll_and_pitch(np.degrees(roll), np.degrees(pitch)))
    time_s, *quaternion = table.columns("time", "w", "x", "y", "z")
    return Channel(time_s, tilt_of_quaternion(*quaternion))


def _read_states(raw: RawLog, tables: Mapping[str, _Table]) -> None:
    """Arming and landing have no time of the vehicle: they get that of the attitude that arrived with them."""
    timed = next((tables[name] for name in _ATTITUDES if name in tables), None)
    if timed is None:
        return
    (vehicle_s,) = timed.columns("time")
    order = np.argsort(timed.stamps_s, kind="stable")
    known_s, vehicle_s = timed.stamps_s[order], vehicle_s[order]
    if "HEARTBEAT" in tables:
        (mode,) = tables["HEARTBEAT"].columns("mode")
        times_s = np.interp(tables["HEARTBEAT"].stamps_s, known_s, vehicle_s)
        raw.armed = FlagChannel(times_s, mode.astype(np.int64) & _ARMED != 0)
    if "EXTENDED_SYS_STATE" in tables:
        (landed,) = tables["EXTENDED_SYS_STATE"].columns("landed")
        times_s = np.interp(tables["EXTENDED_SYS_STATE"].stamps_s, known_s, vehicle_s)
        raw.on_ground = FlagChannel(times_s, landed == _ON_GROUND)
