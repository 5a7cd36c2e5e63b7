"""Writes ULog, DataFlash and telemetry logs byte by byte, as flight controllers do."""

import struct
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from app.flights.flight_log import STANDARD_GRAVITY_M_S2

Row = tuple[float, bytes]
"""Time in seconds, and the record."""


def columns(*values: ArrayLike) -> list[NDArray[np.float64]]:
    """Broadcast the values to columns of equal length."""
    return [np.asarray(one, np.float64) for one in np.broadcast_arrays(*values)]


# ULog


def ulog_record(kind: str, body: bytes) -> bytes:
    return struct.pack("<HB", len(body), ord(kind)) + body


def ulog_topic(number: int, layout: str, rows: Iterable[tuple[float, Sequence[float | int]]]) -> list[Row]:
    """Return samples of topic `number`; `layout` is the `struct` format of the fields after the time."""
    return [
        (at_s, ulog_record("D", struct.pack(f"<HQ{layout}", number, round(at_s * 1e6), *values)))
        for at_s, values in rows
    ]


ULOG_TOPICS = {
    "vehicle_attitude": "uint64_t timestamp;float[4] q;",
    "sensor_combined": "uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;uint8_t clipping;"
    "uint8_t[7] _padding0;",
    "sensor_accel": "uint64_t timestamp;float x;float y;float z;",
    "vehicle_status": "uint64_t timestamp;uint8_t arming_state;uint8_t nav_state;uint8_t[6] _padding0;",
    "vehicle_land_detected": "uint64_t timestamp;bool landed;",
    "vehicle_local_position": "uint64_t timestamp;float x;float y;float z;",
    "nothing_that_is_asked_for": "uint64_t timestamp;nested inner;",
    "nested": "uint64_t timestamp;float value;",
}  # fmt: skip
ULOG_NUMBERS = {"vehicle_attitude": 0, "sensor_combined": 1, "vehicle_status": 2, "vehicle_land_detected": 3,
                "vehicle_local_position": 4, "nothing_that_is_asked_for": 5, "sensor_accel": 6}  # fmt: skip


def ulog_bytes(rows: Iterable[Row]) -> bytes:
    """Return a complete file: header, flags, formats, subscriptions, and the rows sorted by time."""
    head = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1_000_000)
    head += ulog_record("B", bytes(40))
    head += b"".join(ulog_record("F", f"{name}:{fields}".encode()) for name, fields in ULOG_TOPICS.items())
    head += ulog_record("I", b"\x0cchar[3] namePX4")
    head += b"".join(
        ulog_record("A", struct.pack("<BH", 0, number) + name.encode()) for name, number in ULOG_NUMBERS.items()
    )
    return head + b"".join(row for _, row in sorted(rows, key=lambda row: row[0]))


def ulog_attitude(time_s: ArrayLike, tilt_deg: ArrayLike) -> list[Row]:
    """Tilted to the side, with a heading of 90°, which must not affect the tilt."""
    times, tilts = columns(time_s, tilt_deg)
    half, quarter = np.radians(tilts) / 2, np.pi / 4
    roll = np.column_stack([np.cos(half), np.sin(half), 0 * half, 0 * half])
    w, x = roll[:, 0], roll[:, 1]
    turned = np.column_stack([np.cos(quarter) * w, np.cos(quarter) * x, np.sin(quarter) * x, np.sin(quarter) * w])
    return ulog_topic(ULOG_NUMBERS["vehicle_attitude"], "4f", zip(times.tolist(), turned.tolist(), strict=True))


def ulog_force(time_s: ArrayLike, force_g: ArrayLike) -> list[Row]:
    """Without the padding, as PX4 writes it."""
    times, forces = columns(time_s, force_g)
    a = (forces * STANDARD_GRAVITY_M_S2).tolist()
    rows = zip(times.tolist(), ([0, 0, 0, 0.6 * one, 0.0, -0.8 * one, 0] for one in a), strict=True)
    return ulog_topic(ULOG_NUMBERS["sensor_combined"], "6fB", rows)


def ulog_second_force(time_s: ArrayLike, force_g: ArrayLike) -> list[Row]:
    times, forces = columns(time_s, force_g)
    rows = zip(times.tolist(), ([0.0, 0.0, -one] for one in (forces * STANDARD_GRAVITY_M_S2).tolist()), strict=True)
    return ulog_topic(ULOG_NUMBERS["sensor_accel"], "3f", rows)


def ulog_status(*changes: tuple[float, int, int]) -> list[Row]:
    """Time, arming state (2: armed), navigation state."""
    number = ULOG_NUMBERS["vehicle_status"]
    return ulog_topic(number, "2B", ((at_s, (arming, state)) for at_s, arming, state in changes))


def ulog_altitude(time_s: ArrayLike, altitude_m: ArrayLike) -> list[Row]:
    times, altitudes = columns(time_s, altitude_m)
    rows = zip(times.tolist(), ([0.0, 0.0, -one] for one in altitudes.tolist()), strict=True)
    return ulog_topic(ULOG_NUMBERS["vehicle_local_position"], "3f", rows)


# DataFlash

DATAFLASH_TABLES = {
    "ATT": (10, "QccCfff", "TimeUS,Roll,Pitch,Yaw,RollErr,PitchErr,Spare"),
    "IMU": (11, "QBfff", "TimeUS,I,AccX,AccY,AccZ"),
    "EV": (12, "QB", "TimeUS,Id"),
    "MODE": (13, "QMB", "TimeUS,Mode,ModeNum"),
    "MSG": (14, "QZ", "TimeUS,Message"),
    "BARO": (15, "Qf", "TimeUS,Alt"),
    "XYZ": (16, "Qf", "TimeUS,Other"),
}
_STRUCT = {"Q": "Q", "c": "h", "C": "H", "f": "f", "B": "B", "M": "B", "Z": "64s", "e": "i"}
_HEAD = b"\xa3\x95"


def dataflash_format(number: int, name: str, types: str, labels: str) -> bytes:
    length = 3 + struct.calcsize("<" + "".join(_STRUCT[one] for one in types))
    return _HEAD + struct.pack("<BBB4s16s64s", 128, number, length, name.encode(), types.encode(), labels.encode())


def dataflash_bytes(rows: Iterable[Row]) -> bytes:
    head = _HEAD + struct.pack("<BBB4s16s64s", 128, 128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns")
    head += b"".join(dataflash_format(number, name, *rest) for name, (number, *rest) in DATAFLASH_TABLES.items())
    return head + b"".join(row for _, row in sorted(rows, key=lambda row: row[0]))


def dataflash_table(name: str, rows: Iterable[tuple[float, Sequence[float | int | bytes]]]) -> list[Row]:
    number, types, _ = DATAFLASH_TABLES[name]
    layout = "<" + "".join(_STRUCT[one] for one in types)
    return [(at_s, _HEAD + bytes((number,)) + struct.pack(layout, round(at_s * 1e6), *values)) for at_s, values in rows]


def dataflash_attitude(time_s: ArrayLike, tilt_deg: ArrayLike) -> list[Row]:
    times, tilts = columns(time_s, tilt_deg)
    rows = (
        (at_s, (0, round(tilt * 100), 9000, 0.0, 0.0, 0.0)) for at_s, tilt in zip(times.tolist(), tilts, strict=True)
    )
    return dataflash_table("ATT", rows)


def dataflash_force(time_s: ArrayLike, force_g: ArrayLike, sensor: int = 0) -> list[Row]:
    times, forces = columns(time_s, force_g)
    a = (forces * STANDARD_GRAVITY_M_S2).tolist()
    return dataflash_table("IMU", zip(times.tolist(), ([sensor, 0.0, 0.6 * one, -0.8 * one] for one in a), strict=True))


def dataflash_events(*events: tuple[float, int]) -> list[Row]:
    return dataflash_table("EV", ((at_s, (number,)) for at_s, number in events))


def dataflash_modes(*modes: tuple[float, int]) -> list[Row]:
    return dataflash_table("MODE", ((at_s, (number, number)) for at_s, number in modes))


def dataflash_message(at_s: float, text: str) -> list[Row]:
    return dataflash_table("MSG", [(at_s, (text.encode(),))])


def dataflash_altitude(time_s: ArrayLike, altitude_m: ArrayLike) -> list[Row]:
    times, altitudes = columns(time_s, altitude_m)
    return dataflash_table("BARO", zip(times.tolist(), ([one] for one in altitudes.tolist()), strict=True))


# Telemetry (MAVLink in .tlog)

TELEMETRY_STARTS_US = 1_780_000_000_000_000
TELEMETRY = {
    "HEARTBEAT": (0, 50, "IBBBBB"), "RAW_IMU": (27, 144, "Qhhhhhhhhh"), "ATTITUDE": (30, 39, "Iffffff"),
    "HIGHRES_IMU": (105, 93, "QfffffffffffffH"),
}  # fmt: skip
"""Number, what the checksum ends with, and the `struct` format, of MAVLink's common messages."""


def x25(data: bytes) -> int:
    """The checksum of MAVLink, bit by bit."""
    checksum = 0xFFFF
    for byte in data:
        checksum ^= byte
        for _ in range(8):
            checksum = (checksum >> 1) ^ (0x8408 if checksum & 1 else 0)
    return checksum


def telemetry(name: str, at_s: float, *values: float, version: int = 2, system: int = 1, component: int = 1) -> Row:
    """Return one message as a ground station keeps it."""
    number, checksum_end, layout = TELEMETRY[name]
    payload = struct.pack(f"<{layout}", *values)
    if version == 2:
        payload = payload.rstrip(b"\0") or b"\0"
        head = struct.pack("<BBBBBB", len(payload), 0, 0, 0, system, component) + number.to_bytes(3, "little")
        first = b"\xfd"
    else:
        head = struct.pack("<BBBBB", len(payload), 0, system, component, number)
        first = b"\xfe"
    checksum = x25(head + payload + bytes((checksum_end,)))
    stamp = struct.pack(">Q", TELEMETRY_STARTS_US + round(at_s * 1e6))
    return at_s, stamp + first + head + payload + struct.pack("<H", checksum)


def telemetry_attitude(time_s: ArrayLike, tilt_deg: ArrayLike, version: int = 2) -> list[Row]:
    times, tilts = columns(time_s, np.radians(tilt_deg))
    return [
        telemetry("ATTITUDE", at_s, round(at_s * 1000), tilt, 0, 1.2, 0, 0, 0, version=version)
        for at_s, tilt in zip(times.tolist(), tilts.tolist(), strict=True)
    ]


def telemetry_force(time_s: ArrayLike, force_g: ArrayLike, version: int = 2) -> list[Row]:
    times, forces = columns(time_s, force_g)
    return [
        telemetry("RAW_IMU", at_s, round(at_s * 1e6), round(600 * force), 0, round(-800 * force), *[0] * 6,
                  version=version)
        for at_s, force in zip(times.tolist(), forces.tolist(), strict=True)
    ]  # fmt: skip


def telemetry_heartbeat(at_s: float, *, is_armed: bool) -> list[Row]:
    return [telemetry("HEARTBEAT", at_s, 0, 2, 3, 0x80 if is_armed else 0, 4, 3)]


def telemetry_bytes(rows: Iterable[Row]) -> bytes:
    return b"".join(row for _, row in sorted(rows, key=lambda row: row[0]))


# DataFlash as text


def dataflash_text(time_s: ArrayLike, tilt_deg: ArrayLike, force_g: ArrayLike) -> bytes:
    """As a ground station saves a DataFlash log as text."""
    times, tilts, forces = columns(time_s, tilt_deg, np.asarray(force_g) * STANDARD_GRAVITY_M_S2)
    lines = [
        "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns",
        "FMT, 10, 25, ATT, Qccc, TimeUS,Roll,Pitch,Yaw",
        "FMT, 11, 24, IMU, QBfff, TimeUS,I,AccX,AccY,AccZ",
        "FMT, 12, 24, MSG, QZ, TimeUS,Message",
        "MSG, 0, ArduCopter V4.5.1, a text with commas",
    ]
    for at_s, tilt, force in zip(times.tolist(), tilts.tolist(), forces.tolist(), strict=True):
        lines.append(f"ATT, {round(at_s * 1e6)}, {tilt:.2f}, 0, 90")
        lines.append(f"IMU, {round(at_s * 1e6)}, 0, 0, {0.6 * force:.5f}, {-0.8 * force:.5f}")
    return "".join(f"{line}\r\n" for line in lines).encode()
