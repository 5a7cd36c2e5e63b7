"""Writes ULog, DataFlash and telemetry logs byte by byte, as flight controllers do."""

import struct
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from app.flights.flight_log import STANDARD_GRAVITY_M_S2

Row = tuple[float, bytes]
"""Time in seconds, and the record."""


def rows_of(time_s: ArrayLike, *values: ArrayLike) -> Iterator[tuple[float, ...]]:
    """The time and the values of each row; what is one number is the same in all."""
    columns = np.broadcast_arrays(np.atleast_1d(time_s), *values)
    return zip(*(np.asarray(column, np.float64).tolist() for column in columns), strict=True)


def packed(letters: str, *values: float) -> bytes:
    """`letters`: those of `struct`, one for each value."""
    numbers = (one if letter in "fd" else round(one) for letter, one in zip(letters, values, strict=True))
    return struct.pack(f"<{letters}", *numbers)


def in_order(rows: Iterable[Row]) -> bytes:
    return b"".join(row for _, row in sorted(rows, key=lambda row: row[0]))


# ULog

ULOG_TOPICS = {
    "vehicle_attitude": ("ffff", "float[4] q;"),
    # Without the padding, as PX4 writes it.
    "sensor_combined": ("ffffffB", "float[3] gyro_rad;float[3] accelerometer_m_s2;uint8_t clip;uint8_t[7] _padding0;"),
    "vehicle_status": ("BB", "uint8_t arming_state;uint8_t nav_state;uint8_t[6] _padding0;"),
    "vehicle_local_position": ("fff", "float x;float y;float z;"),
    "nothing_that_is_asked_for": ("", "nested inner;"),
    "sensor_accel": ("fff", "float x;float y;float z;"),
    "nested": ("f", "float value;"),
}  # fmt: skip


def ulog_record(kind: str, body: bytes) -> bytes:
    return struct.pack("<HB", len(body), ord(kind)) + body


def ulog(topic: str, time_s: ArrayLike, *values: ArrayLike) -> list[Row]:
    number, letters = list(ULOG_TOPICS).index(topic), f"HQ{ULOG_TOPICS[topic][0]}"
    rows = rows_of(time_s, *values)
    return [(at_s, ulog_record("D", packed(letters, number, at_s * 1e6, *row))) for at_s, *row in rows]


def ulog_bytes(time_s: ArrayLike, tilt_deg: ArrayLike, force_g: ArrayLike, *more: Row) -> bytes:
    """A complete file. Tilted to the side, with a heading of 90°, which must not affect the tilt."""
    half, quarter = np.radians(np.asarray(tilt_deg)) / 2, np.pi / 4
    w, x = np.cos(half), np.sin(half)
    turned = np.cos(quarter) * w, np.cos(quarter) * x, np.sin(quarter) * x, np.sin(quarter) * w
    a = np.asarray(force_g) * STANDARD_GRAVITY_M_S2
    rows = ulog("vehicle_attitude", time_s, *turned) + ulog("sensor_combined", time_s, 0, 0, 0, 0.6 * a, 0, -0.8 * a, 0)
    head = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1_000_000) + ulog_record("B", bytes(40))
    for name, (_, fields) in ULOG_TOPICS.items():
        head += ulog_record("F", f"{name}:uint64_t timestamp;{fields}".encode())
    head += ulog_record("I", b"\x0cchar[3] namePX4")
    for number, name in enumerate(ULOG_TOPICS):
        head += ulog_record("A", struct.pack("<BH", 0, number) + name.encode())
    return head + in_order([*rows, *more])


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
# As `struct` has them.
_LETTERS = str.maketrans({"c": "h", "C": "H", "M": "B", "Z": "64s"})
_HEAD = b"\xa3\x95"


def dataflash(table: str, time_s: ArrayLike, *values: ArrayLike) -> list[Row]:
    number, types, _ = DATAFLASH_TABLES[table]
    head, letters = _HEAD + bytes((number,)), types.translate(_LETTERS)
    return [(at_s, head + packed(letters, at_s * 1e6, *row)) for at_s, *row in rows_of(time_s, *values)]


def dataflash_format(number: int, name: str, types: str, labels: str) -> bytes:
    length = 3 + struct.calcsize(f"<{types.translate(_LETTERS)}")
    return _HEAD + struct.pack("<BBB4s16s64s", 128, number, length, name.encode(), types.encode(), labels.encode())


def dataflash_bytes(time_s: ArrayLike, tilt_deg: ArrayLike, force_g: ArrayLike, *more: Row) -> bytes:
    rows = dataflash("ATT", time_s, 0, np.asarray(tilt_deg) * 100, 9000, 0, 0, 0) + dataflash_force(time_s, force_g)
    head = _HEAD + struct.pack("<BBB4s16s64s", 128, 128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns")
    formats = (dataflash_format(number, name, *rest) for name, (number, *rest) in DATAFLASH_TABLES.items())
    return head + b"".join(formats) + in_order([*rows, *more])


def dataflash_force(time_s: ArrayLike, force_g: ArrayLike, sensor: int = 0) -> list[Row]:
    a = np.asarray(force_g) * STANDARD_GRAVITY_M_S2
    return dataflash("IMU", time_s, sensor, 0, 0.6 * a, -0.8 * a)


def dataflash_message(at_s: float, text: str) -> list[Row]:
    return [(at_s, _HEAD + struct.pack("<BQ64s", 14, round(at_s * 1e6), text.encode()))]


def dataflash_text(time_s: ArrayLike, tilt_deg: ArrayLike, force_g: ArrayLike) -> bytes:
    """As a ground station saves a log as text."""
    lines = [
        "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns",
        "FMT, 10, 25, ATT, Qccc, TimeUS,Roll,Pitch,Yaw",
        "FMT, 11, 24, IMU, QBfff, TimeUS,I,AccX,AccY,AccZ",
        "FMT, 12, 24, MSG, QZ, TimeUS,Message",
        "MSG, 0, ArduCopter V4.5.1, a text with commas",
    ]
    for at_s, tilt, force in rows_of(time_s, tilt_deg, np.asarray(force_g) * STANDARD_GRAVITY_M_S2):
        lines.append(f"ATT, {round(at_s * 1e6)}, {tilt:.2f}, 0, 90")
        lines.append(f"IMU, {round(at_s * 1e6)}, 0, 0, {0.6 * force:.5f}, {-0.8 * force:.5f}")
    return "".join(f"{line}\r\n" for line in lines).encode()


# Telemetry (MAVLink in .tlog)

TELEMETRY_STARTS_US = 1_780_000_000_000_000
TELEMETRY = {
    "HEARTBEAT": (0, 50, "IBBBBB"), "RAW_IMU": (27, 144, "Qhhhhhhhhh"), "ATTITUDE": (30, 39, "Iffffff"),
}  # fmt: skip
"""Number, what the checksum ends with, and the letters of `struct`, of MAVLink's common messages."""


def x25(data: bytes) -> int:
    """The checksum of MAVLink, bit by bit."""
    checksum = 0xFFFF
    for byte in data:
        checksum ^= byte
        for _ in range(8):
            checksum = (checksum >> 1) ^ (0x8408 if checksum & 1 else 0)
    return checksum


def telemetry(name: str, at_s: float, *values: float, version: int = 2, system: int = 1, component: int = 1) -> Row:
    """One message as a ground station keeps it."""
    number, checksum_end, letters = TELEMETRY[name]
    payload = packed(letters, *values)
    if version == 2:
        payload = payload.rstrip(b"\0") or b"\0"
        head = struct.pack("<BBBBBB", len(payload), 0, 0, 0, system, component) + number.to_bytes(3, "little")
    else:
        head = struct.pack("<BBBBB", len(payload), 0, system, component, number)
    checksum = x25(head + payload + bytes((checksum_end,)))
    stamp = struct.pack(">Q", TELEMETRY_STARTS_US + round(at_s * 1e6))
    first = b"\xfd" if version == 2 else b"\xfe"
    return at_s, stamp + first + head + payload + struct.pack("<H", checksum)


def telemetry_heartbeat(at_s: float, *, is_armed: bool) -> Row:
    return telemetry("HEARTBEAT", at_s, 0, 2, 3, 0x80 if is_armed else 0, 4, 3)


def telemetry_bytes(time_s: ArrayLike, tilt_deg: ArrayLike, force_g: ArrayLike, *more: Row, version: int = 2) -> bytes:
    rows = list(more)
    for at_s, tilt, force in rows_of(time_s, np.radians(tilt_deg), force_g):
        rows.append(telemetry("ATTITUDE", at_s, at_s * 1e3, tilt, 0, 1.2, 0, 0, 0, version=version))
        raw = telemetry("RAW_IMU", at_s, at_s * 1e6, 600 * force, 0, -800 * force, *[0] * 6, version=version)
        rows.append(raw)
    return in_order(rows)
