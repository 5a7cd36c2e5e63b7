"""Reads telemetry as ground stations keep it (`.tlog`): MAVLink 1 and 2, each message behind the time of its arrival.

Attitude, acceleration of every sensor, altitude, arming. Times are the vehicle's own. Each message has a
checksum, so damage costs the damaged messages and nothing else.
"""

import re
from binascii import crc_hqx
from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np

from app.flights.raw_log import (
    STANDARD_GRAVITY_M_S2,
    TIME,
    Channel,
    ChannelSource,
    Layout,
    RawLog,
    Table,
    channels_of,
    columns_of,
    force_of_axes,
    tilt_of_roll_and_pitch,
    unreadable,
)
from protocol.translatable import marked

# Microseconds since 1970 before each message, the most significant byte first: the years 2000 to 2100.
_STAMP_BYTES: Final = 8
_STAMPS_US: Final = (946_684_800_000_000, 4_102_444_800_000_000)
_MAVLINK_1, _MAVLINK_2 = 0xFE, 0xFD
_FIRST_BYTE: Final = re.compile(rb"[\xfe\xfd]")
# Bytes of a message before its payload, by the first of them.
_HEAD_BYTES: Final = {_MAVLINK_1: 6, _MAVLINK_2: 10}
_CHECKSUM_BYTES: Final = 2
_SIGNED: Final = 0x01
_SIGNATURE_BYTES: Final = 13
# The component that flies; gimbals and cameras have attitudes, too.
_AUTOPILOT: Final = 1
_ARMED: Final = 0x80
# A vehicle's time that is later counts from 1970, and has nothing to do with the others.
_LATEST_S: Final = 1e8
_REVERSED: Final = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))


class _Kind(NamedTuple):
    """A message: what its checksum ends with, and its payload, with the stamp before it."""

    name: str
    checksum_end: int
    layout: Layout
    scales: Mapping[str, float]


def _kind(name: str, checksum_end: int, size: int, **fields: tuple[int, str, float]) -> _Kind:
    """Each field with its place in the payload of `size` bytes, its type, and its factor."""
    layout = np.dtype({
        "names": ["stamp", *fields],
        "formats": [">u8", *(kind for _, kind, _ in fields.values())],
        "offsets": [0, *(_STAMP_BYTES + place for place, _, _ in fields.values())],
        "itemsize": _STAMP_BYTES + size,
    })  # fmt: skip
    scales = {"stamp": 1e-6, **{field: scale for field, (_, _, scale) in fields.items()}}
    return _Kind(name, checksum_end, layout, scales)


_BOOT_MS: Final = (0, "<u4", 1e-3)
_TIME_US: Final = (0, "<u8", 1e-6)
_DEG: Final = 180 / np.pi
_MILLI_G: Final = 1e-3 * STANDARD_GRAVITY_M_S2
_SCALED: Final = {"x": (4, "<i2", _MILLI_G), "y": (6, "<i2", _MILLI_G), "z": (8, "<i2", _MILLI_G)}
_RAW: Final = {"x": (8, "<i2", _MILLI_G), "y": (10, "<i2", _MILLI_G), "z": (12, "<i2", _MILLI_G)}
_HIGHRES: Final = {"x": (8, "<f4", 1.0), "y": (12, "<f4", 1.0), "z": (16, "<f4", 1.0)}
_ATTITUDE: Final = 30
_KINDS: Final = {
    0: _kind("HEARTBEAT", 50, 9, mode=(6, "<u1", 1.0)),
    _ATTITUDE: _kind("ATTITUDE", 39, 28, time=_BOOT_MS, roll=(4, "<f4", _DEG), pitch=(8, "<f4", _DEG)),
    33: _kind("GLOBAL_POSITION_INT", 104, 28, time=_BOOT_MS, altitude=(16, "<i4", 1e-3)),
    105: _kind("HIGHRES_IMU", 93, 62, time=_TIME_US, **_HIGHRES),
    27: _kind("RAW_IMU", 144, 26, time=_TIME_US, **_RAW),
    26: _kind("SCALED_IMU", 170, 22, time=_BOOT_MS, **_SCALED),
    116: _kind("SCALED_IMU2", 76, 22, time=_BOOT_MS, **_SCALED),
    129: _kind("SCALED_IMU3", 46, 22, time=_BOOT_MS, **_SCALED),
}
_TILTS: Final = (ChannelSource("ATTITUDE", ("roll", "pitch"), tilt_of_roll_and_pitch),)
_FORCES: Final = tuple(
    ChannelSource(table, ("x", "y", "z"), force_of_axes)
    for table in ("HIGHRES_IMU", "RAW_IMU", "SCALED_IMU", "SCALED_IMU2", "SCALED_IMU3")
)
_ALTITUDES: Final = (ChannelSource("GLOBAL_POSITION_INT", ("altitude",)),)
_ARMING: Final = (ChannelSource("HEARTBEAT", ("mode",), lambda mode: mode.astype(np.int64) & _ARMED),)
_CLOCK: Final = (ChannelSource("ATTITUDE", ("stamp",)),)


def is_telemetry(start: bytes) -> bool:
    """Whether a file that begins so is telemetry of a ground station."""
    stamp_us = int.from_bytes(start[:_STAMP_BYTES], "big")
    return start[_STAMP_BYTES : _STAMP_BYTES + 1] in (b"\xfd", b"\xfe") and _STAMPS_US[0] <= stamp_us <= _STAMPS_US[1]


def x25(data: bytes) -> int:
    """MAVLink's checksum: the one of the standard library with the bits of all bytes reversed, which is fast."""
    reversed_bits = crc_hqx(data.translate(_REVERSED), 0xFFFF)
    return _REVERSED[reversed_bits >> 8] | _REVERSED[reversed_bits & 0xFF] << 8


class TelemetryFile:
    def __init__(self, data: bytes) -> None:
        self._data = data
        # Stamps and payloads of the messages that are asked for, by the number of the vehicle and that of the message.
        self._found: dict[tuple[int, int], bytearray] = {}
        # Bytes that are no messages: damage.
        self.skipped_bytes = 0
        # Where the last message ends.
        self.read_until = 0
        for first in _FIRST_BYTE.finditer(data, _STAMP_BYTES):
            begin = first.start() - _STAMP_BYTES
            if begin >= self.read_until:
                end = self._read(begin)
                if end is not None:
                    self.skipped_bytes += begin - self.read_until
                    self.read_until = end
        self.skipped_bytes += len(data) - self.read_until

    def _read(self, begin: int) -> int | None:
        """Where the message ends that begins here; None where there cannot be one, or where its checksum is wrong."""
        data, head_at = self._data, begin + _STAMP_BYTES
        if not is_telemetry(data[begin : head_at + 1]):
            return None
        head = data[head_at : head_at + _HEAD_BYTES[data[head_at]]]
        if len(head) < _HEAD_BYTES[head[0]]:
            return None
        payload_at = head_at + len(head)
        payload_end = payload_at + head[1]
        end = payload_end + _CHECKSUM_BYTES
        if head[0] == _MAVLINK_1:
            vehicle, component, number = head[3:6]
        else:
            vehicle, component = head[5:7]
            number = int.from_bytes(head[7:10], "little")
            if head[2] & _SIGNED:
                end += _SIGNATURE_BYTES
        if end > len(data):
            return None
        kind = _KINDS.get(number)
        if kind is None:
            # The checksum of a message that nobody asks for is not known: the next one has to be there.
            return end if end == len(data) or is_telemetry(data[end : end + _STAMP_BYTES + 1]) else None
        checksum = int.from_bytes(data[payload_end : payload_end + _CHECKSUM_BYTES], "little")
        if checksum != x25(data[head_at + 1 : payload_end] + bytes((kind.checksum_end,))):
            return None
        if component == _AUTOPILOT:
            size = kind.layout.itemsize
            # MAVLink 2 leaves out zeros at the end of a payload.
            record = (data[begin:head_at] + data[payload_at:payload_end]).ljust(size, b"\0")
            self._found.setdefault((vehicle, number), bytearray()).extend(record[:size])
        return end

    def tables(self) -> dict[str, list[Table]]:
        """Those of the one vehicle with an attitude. Raises `UserError` where there are more."""
        vehicles = {vehicle for vehicle, number in self._found if number == _ATTITUDE}
        if len(vehicles) > 1:
            raise unreadable(marked("more than one vehicle in one file"))
        tables: dict[str, list[Table]] = {}
        for (vehicle, number), records in self._found.items():
            kind = _KINDS[number]
            places = np.arange(0, len(records), kind.layout.itemsize)
            table = columns_of(bytes(records), kind.layout, places, kind.scales)
            # Arming has no time of the vehicle.
            table.setdefault(TIME, table["stamp"])
            if vehicle in vehicles or not vehicles:
                tables.setdefault(kind.name, []).append(table)
        return tables


def read_telemetry(data: bytes, name: str) -> RawLog:
    """Raises `UserError`."""
    file = TelemetryFile(data)
    tables = file.tables()
    raw = RawLog(name=name, tilts_deg=channels_of(tables, _TILTS), altitudes_m=channels_of(tables, _ALTITUDES))
    raw.forces_g = [force for force in channels_of(tables, _FORCES) if np.median(force.time_s) <= _LATEST_S]
    # Arming has no time of the vehicle: it gets that of the attitude that arrived with it.
    for clock in channels_of(tables, _CLOCK):
        order = np.argsort(clock.values, kind="stable")
        for armed in channels_of(tables, _ARMING):
            time_s = np.interp(armed.time_s, clock.values[order], clock.time_s[order])
            raw.armed.append(Channel(time_s, armed.values))
    raw.note_damage(file.skipped_bytes, file.read_until, len(data))
    return raw
