"""Reads the logs of autopilots: attitude, acceleration of every sensor, altitude, arming.

PX4's ULog (`.ulg`), ArduPilot's DataFlash, binary (`.bin`) or text (`.log`), and MAVLink telemetry as ground stations
keep it (`.tlog`). Damage costs the damaged records and nothing else. Read without pyulog, which a file of 113 bytes
keeps busy without end, and pymavlink, which is larger than the rest of the program: see docs/flight-logs.md.
"""

import re
from array import array
from binascii import crc_hqx
from collections.abc import Iterator, Mapping
from io import BytesIO
from itertools import chain
from struct import Struct
from typing import Final, NamedTuple

import numpy as np

from app.flights.flight_log import (
    AT_ONCE,
    STANDARD_GRAVITY_M_S2,
    TIME,
    Channel,
    ChannelSource,
    Layout,
    Places,
    RawLog,
    Table,
    channels_of,
    columns_of,
    force_of_axes,
    tilt_of_quaternion,
    tilt_of_roll_and_pitch,
    unreadable,
)
from protocol.translatable import marked

_MAX_SENSORS: Final = 6

# ULog, versions 0 and 1: https://docs.px4.io/main/en/dev_log/ulog_file_format.html
#
# A record is the size of its body in two bytes, its kind in one, and its body. Formats (`F`), subscriptions (`A`) and
# samples (`D`) are known by what is in them, wherever they stand: sync records, which many files have not, are not
# needed.

_ULOG_HEADER_BYTES: Final = 16
_ULOG_RECORD_HEAD: Final = 3
_ULOG_ID_BYTES: Final = 2
_ULOG_KINDS: Final = frozenset(b"BFIMPQARDLCSO")
_ULOG_TYPES: Final[Mapping[str, str]] = {
    "int8_t": "<i1", "uint8_t": "<u1", "bool": "<u1", "char": "S1",
    "int16_t": "<i2", "uint16_t": "<u2", "int32_t": "<i4", "uint32_t": "<u4",
    "int64_t": "<i8", "uint64_t": "<u8", "float": "<f4", "double": "<f8",
}  # fmt: skip
_FORMAT: Final = re.compile(rb"([A-Za-z]\w*):([\w/\[\] ;]+)")
_FIELD: Final = re.compile(r"([A-Za-z_][A-Za-z0-9_/]*)(?:\[(\d{1,5})\])? ([A-Za-z_][A-Za-z0-9_]*)")
_LARGEST: Final = 0xFFFF
_LONGEST_FORMAT: Final = 5000
_LONGEST_NAME: Final = 100
# Longer arrays, such as texts, are one field.
_MOST_ELEMENTS: Final = 16
_PADDING: Final = "_padding"
# The incompatible flag of data that is appended after the flight, the only one that is understood.
_APPENDED: Final = 0x01
# vehicle_status.arming_state
_ULOG_ARMED: Final = 2


_ULOG_TILTS: Final = (ChannelSource("vehicle_attitude", ("q[0]", "q[1]", "q[2]", "q[3]"), tilt_of_quaternion),)
# What the estimator uses, of which the first that is there counts; and each sensor.
_ESTIMATOR_FORCES: Final = (
    ChannelSource("sensor_combined", tuple(f"accelerometer_m_s2[{axis}]" for axis in range(3)), force_of_axes),
    ChannelSource("vehicle_acceleration", ("xyz[0]", "xyz[1]", "xyz[2]"), force_of_axes),
)
_SENSOR_FORCES: Final = (ChannelSource("sensor_accel", ("x", "y", "z"), force_of_axes),)
_ULOG_ALTITUDES: Final = (
    ChannelSource("vehicle_local_position", ("z",), np.negative),
    ChannelSource("vehicle_air_data", ("baro_alt_meter",)),
)
_ULOG_ARMING: Final = (ChannelSource("vehicle_status", ("arming_state",), lambda state: state == _ULOG_ARMED),)
_ULOG_SOURCES: Final = (*_ULOG_TILTS, *_ESTIMATOR_FORCES, *_SENSOR_FORCES, *_ULOG_ALTITUDES, *_ULOG_ARMING)
# The columns of each topic that is asked for.
_WANTED: Final = {one.table: {TIME: 1e-6} | dict.fromkeys(one.columns, 1.0) for one in _ULOG_SOURCES}


class UlogFile:
    """A ULog file (PX4), read once. Raises `UserError`."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._bytes = np.frombuffer(data, np.uint8)
        # By name, an instance of a topic each.
        self.topics: dict[str, list[Table]] = {}
        # Bytes that are no records: damage.
        self.skipped_bytes = 0
        # Where the last record ends.
        self.read_until = len(data)
        # Version 1 begins with its flags, of which the second eight bytes say what a reader must understand.
        first = data[_ULOG_HEADER_BYTES : _ULOG_HEADER_BYTES + _ULOG_RECORD_HEAD + 16]
        if first[2:3] == b"B" and int.from_bytes(first[_ULOG_RECORD_HEAD + 8 :], "little") & ~_APPENDED:
            raise unreadable(marked("written by a newer version"))
        # Those that are understood.
        layouts: dict[str, Layout] = {}
        for begin, end in chain(*self._found("F", _LONGEST_FORMAT)):
            match = _FORMAT.fullmatch(data, begin + _ULOG_RECORD_HEAD, end)
            layout = None if match is None else _layout_of(match[2].decode())
            if match is not None and layout is not None:
                layouts.setdefault(match[1].decode(), layout)
        # A subscription gives a topic and its instance the number that stands in their samples.
        subscribed: dict[int, tuple[str, int]] = {}
        for begin, end in chain(*self._found("A", _LONGEST_NAME)):
            name = data[begin + 6 : end].decode("latin-1")
            if name in layouts:
                number = int.from_bytes(data[begin + 4 : begin + 6], "little")
                subscribed.setdefault(number, (name, data[begin + 3]))
        samples = self._samples({number: layouts[name] for number, (name, _) in subscribed.items()})
        numbers = self._numbers_at(samples[:, 0] + _ULOG_RECORD_HEAD)
        for number, (name, _) in sorted(subscribed.items(), key=lambda one: one[1]):
            if name in _WANTED:
                places = samples[numbers == number, 0] + _ULOG_RECORD_HEAD + _ULOG_ID_BYTES
                table = columns_of(data, layouts[name], places, _WANTED[name])
                if table:
                    self.topics.setdefault(name, []).append(table)
        self._read_between(samples)

    def _found(self, kind: str, longest: int) -> Iterator[Places]:
        """Where records of a kind may begin and end, shape (number, 2), in one part of the file after the other."""
        for first in range(_ULOG_HEADER_BYTES, len(self._data), AT_ONCE):
            begins = np.flatnonzero(self._bytes[first + 2 : first + 2 + AT_ONCE] == ord(kind)) + first
            sizes = self._numbers_at(begins)
            ends = begins + _ULOG_RECORD_HEAD + sizes
            fits = (sizes > _ULOG_ID_BYTES) & (sizes <= longest) & (ends <= len(self._data))
            yield np.column_stack((begins[fits], ends[fits]))

    def _numbers_at(self, places: Places) -> Places:
        """Numbers of two bytes."""
        numbers: Places = self._bytes[places] + 256 * self._bytes[places + 1].astype(np.int64)
        return numbers

    def _samples(self, layouts: Mapping[int, Layout]) -> Places:
        """Where samples of known topics begin and end. `layouts`: by the number in them."""
        # What a sample may have at least and at most, by its number: padding at its end is not written.
        least, most = np.ones(_LARGEST + 1, np.int64), np.zeros(_LARGEST + 1, np.int64)
        for number, layout in layouts.items():
            most[number] = least[number] = _ULOG_RECORD_HEAD + _ULOG_ID_BYTES + layout.itemsize
            if (layout.names or ("",))[-1].startswith(_PADDING):
                least[number] -= layout[-1].itemsize
        parts = [np.empty((0, 2), np.int64)]
        for part in self._found("D", _LARGEST):
            sizes, numbers = part[:, 1] - part[:, 0], self._numbers_at(part[:, 0] + _ULOG_RECORD_HEAD)
            parts.append(part[(least[numbers] <= sizes) & (sizes <= most[numbers])])
        return np.concatenate(parts)

    def _read_between(self, samples: Places) -> None:
        """Between samples there are whole other records, or damage."""
        bounds = np.concatenate(((0, _ULOG_HEADER_BYTES), samples.ravel(), (len(self._data),) * 2)).reshape(-1, 2)
        for row in np.flatnonzero(bounds[1:, 0] > bounds[:-1, 1]).tolist():
            place, stop = int(bounds[row, 1]), int(bounds[row + 1, 0])
            while place + _ULOG_RECORD_HEAD < stop:
                size, kind = int.from_bytes(self._data[place : place + 2], "little"), self._data[place + 2]
                end = place + _ULOG_RECORD_HEAD + size
                if end > stop or size == 0 or kind not in _ULOG_KINDS:
                    break
                place = end
            self.skipped_bytes += stop - place
            if stop == len(self._data):
                self.read_until = place


def _layout_of(fields: str) -> Layout | None:
    """The layout of a format; None where it is not understood.

    An element of an array is a field like `q[0]`. No topic that is read has formats within its format.
    """
    parts: list[tuple[str, object]] = []
    for text in fields.rstrip(";").split(";"):
        match = _FIELD.fullmatch(text)
        if match is None or match[1] not in _ULOG_TYPES:
            return None
        name, count, label = match.groups()
        kind = np.dtype(_ULOG_TYPES[name])
        if count is None:
            parts.append((TIME if label == "timestamp" else label, kind))
        elif int(count) <= _MOST_ELEMENTS and not label.startswith(_PADDING):
            parts += [(f"{label}[{number}]", kind) for number in range(int(count))]
        else:
            parts.append((label, (kind, int(count))))
    try:
        return np.dtype(parts)
    except ValueError:  # two fields of one name, or too large
        return None


def read_ulog(data: bytes) -> RawLog:
    """Read a ULog file (PX4). Raises `UserError`."""
    file = UlogFile(data)
    raw = RawLog(tilts_deg=channels_of(file.topics, _ULOG_TILTS))
    estimator = [source for source in _ESTIMATOR_FORCES if source.table in file.topics]
    raw.forces_g = channels_of(file.topics, (*estimator[:1], *_SENSOR_FORCES))[:_MAX_SENSORS]
    raw.altitudes_m = channels_of(file.topics, _ULOG_ALTITUDES)
    raw.armed = channels_of(file.topics, _ULOG_ARMING)
    raw.note_damage(file.skipped_bytes, file.read_until, len(data))
    return raw


# DataFlash. It defines its own records: a binary `FMT` record, or a line `FMT`, names the columns of a table.

MAGIC: Final = b"\xa3\x95"
# A line of a log that was saved as text.
TEXT_FORMAT: Final = re.compile(rb"^FMT,", re.MULTILINE)
_FORMAT_KIND: Final = 128
_DF_HEAD_BYTES: Final = 3
# A definition: the kind and the length of its records, the name of the table, the letters and the names of its columns.
_DF_FORMAT: Final = Struct("<3xBB4s16s64s")
_FORMAT_HEAD: Final = re.compile(rb"\xa3\x95\x80..[A-Za-z0-9]{1,4}", re.DOTALL)
_DF_TYPES: Final[Mapping[str, str]] = {
    "a": "S64", "b": "<i1", "B": "<u1", "h": "<i2", "H": "<u2", "i": "<i4", "I": "<u4", "f": "<f4", "d": "<f8",
    "n": "S4", "N": "S16", "Z": "S64", "c": "<i2", "C": "<u2", "e": "<i4", "E": "<u4", "L": "<i4", "M": "<u1",
    "q": "<i8", "Q": "<u8", "g": "<f2",
}  # fmt: skip
_SCALES: Final = {"c": 0.01, "C": 0.01, "e": 0.01, "E": 0.01, "L": 1e-7}
_CLOCK_US: Final = "TimeUS"
# The number of the sensor; older logs have a table for each.
_SENSOR: Final = "I"
_DF_TILTS: Final = tuple(ChannelSource(table, ("Roll", "Pitch"), tilt_of_roll_and_pitch) for table in ("ATT", "AHR2"))
_DF_FORCES: Final = tuple(
    ChannelSource(table, ("AccX", "AccY", "AccZ"), force_of_axes)
    for table in ("IMU", "IMU2", "IMU3", "ACC", "ACC1", "ACC2", "ACC3")
)
# The estimator's altitude, else the barometer's.
_DF_ALTITUDES: Final = tuple(
    ChannelSource(table, (column,))
    for table, column in (("POS", "RelHomeAlt"), ("POS", "Alt"), ("CTUN", "Alt"), ("BARO", "Alt"))
)
# Of events number 10 and 11 tell.
_DF_ARMING: Final = (
    ChannelSource("ARM", ("ArmState",)),
    ChannelSource("EV", ("Id",), lambda event: np.select([event == 10, event == 11], [1.0, 0.0], np.nan)),
)
_DF_SOURCES: Final = (*_DF_TILTS, *_DF_FORCES, *_DF_ALTITUDES, *_DF_ARMING)
_DF_TABLES: Final = frozenset(one.table for one in _DF_SOURCES)
_DF_COLUMNS: Final = frozenset((_CLOCK_US, _SENSOR, *chain.from_iterable(one.columns for one in _DF_SOURCES)))


def read_dataflash(data: bytes) -> RawLog:
    """Reads a binary or a text log."""
    file = DataflashFile(data)
    raw = RawLog(tilts_deg=channels_of(file.tables, _DF_TILTS))
    raw.forces_g = channels_of(file.tables, _DF_FORCES)[:_MAX_SENSORS]
    raw.altitudes_m = channels_of(file.tables, _DF_ALTITUDES)
    for time_s, values in channels_of(file.tables, _DF_ARMING):
        rows = np.flatnonzero(np.isfinite(values))
        if len(rows):
            # Each sample is a change: before the first one the flag had the opposite value.
            before = float(values[rows[0]] == 0)
            raw.armed.append(Channel(np.append(-np.inf, time_s[rows]), np.append(before, values[rows])))
    raw.note_damage(file.skipped_bytes, file.read_until, len(data))
    return raw


class DataflashFile:
    """A log, binary or text: its tables that are asked for, by name. Damage costs the damaged record."""

    def __init__(self, data: bytes) -> None:
        # By name, one for each sensor.
        self.tables: dict[str, list[Table]] = {}
        # Bytes that are no records of a binary log: damage.
        self.skipped_bytes = 0
        # Where the last record ends.
        self.read_until = 0
        if data.startswith(MAGIC):
            self._read_binary(data)
        else:
            self._read_text(data)

    def _read_binary(self, data: bytes) -> None:
        formats: dict[int, tuple[str, str, list[str]]] = {}
        # 0 where a kind is not defined.
        lengths = np.zeros(256, np.int64)
        lengths[_FORMAT_KIND] = _DF_FORMAT.size
        for found in _FORMAT_HEAD.finditer(data):
            if found.start() + _DF_FORMAT.size > len(data):
                break
            kind, length, *texts = _DF_FORMAT.unpack_from(data, found.start())
            name, letters, columns = (text.split(b"\0")[0].decode("latin-1") for text in texts)
            # The first definition of a kind counts.
            if length >= _DF_HEAD_BYTES and not lengths[kind]:
                lengths[kind] = length
                formats[kind] = name, letters, [label.strip() for label in columns.split(",")]
        begins = self._records(data, lengths)
        kinds = np.frombuffer(data, np.uint8)[begins + 2]
        for kind, (name, letters, labels) in formats.items():
            is_understood = set(letters) <= _DF_TYPES.keys() and len(set(labels)) == len(labels)
            if name in _DF_TABLES and name not in self.tables and is_understood:
                types = dict(zip(labels, letters, strict=False))
                layout = np.dtype([(label, _DF_TYPES[letter]) for label, letter in types.items()])
                wanted = {label: _SCALES.get(letter, 1.0) for label, letter in types.items() if label in _DF_COLUMNS}
                if layout.itemsize + _DF_HEAD_BYTES <= lengths[kind]:
                    table = columns_of(data, layout, begins[kinds == kind] + _DF_HEAD_BYTES, wanted)
                    self.tables[name] = _by_sensor(table)

    def _records(self, data: bytes, lengths: Places) -> Places:
        """Where records of defined kinds begin. By chance the magic stands within others, too."""
        read = np.frombuffer(data, np.uint8)
        records = array("q")
        place = 0
        for first in range(0, len(data) - 2, AT_ONCE):
            part = read[first : first + AT_ONCE + 2]
            begins = np.flatnonzero((part[:-2] == MAGIC[0]) & (part[1:-1] == MAGIC[1])) + first
            ends = begins + lengths[read[begins + 2]]
            fits = (ends > begins) & (ends <= len(data))
            for begin, end in zip(begins[fits].tolist(), ends[fits].tolist(), strict=True):
                # Behind damage a record is believed if another one, or nothing, follows it.
                if begin == place or (begin > place and data[end : end + len(MAGIC)] in (MAGIC, b"")):
                    records.append(begin)
                    self.skipped_bytes += begin - place
                    place = end
        self.skipped_bytes += len(data) - place
        self.read_until = place
        return np.array(records, np.int64)

    def _read_text(self, data: bytes) -> None:
        """A line that is no whole row of a table is not used."""
        # Of the tables that are asked for: the number of cells, the places of the columns by label, and their numbers.
        tables: dict[str, tuple[int, dict[str, int], array[float]]] = {}
        place = 0
        for line in BytesIO(data):
            place += len(line)
            name, _, rest = line.decode("latin-1").partition(",")
            if name not in tables:
                self.read_until = place
            if name in tables and line.endswith(b"\n"):
                width, places, numbers = tables[name]
                cells = rest.split(",")
                if len(cells) == width:
                    numbers.extend([_number(cells[number]) for number in places.values()])
                    self.read_until = place
            elif name == "FMT" and rest.count(",") >= 4:
                _, _, table, _, *labels = (cell.strip() for cell in rest.split(","))
                if table in _DF_TABLES:
                    wanted = {label: number for number, label in enumerate(labels) if label in _DF_COLUMNS}
                    tables.setdefault(table, (len(labels), wanted, array("d")))
        for name, (_, places, numbers) in tables.items():
            if numbers:
                columns = np.array(numbers).reshape(-1, len(places)).T
                self.tables[name] = _by_sensor(dict(zip(places, columns, strict=True)))


def _number(cell: str) -> float:
    """A text, or damage, costs its own cell."""
    try:
        return float(cell)
    except ValueError:
        return np.nan


def _by_sensor(table: Table) -> list[Table]:
    """Split a table by its sensors, with seconds. Newer logs number the sensors within one table."""
    if _CLOCK_US in table:
        table[TIME] = table[_CLOCK_US] * 1e-6
    if _SENSOR not in table:
        return [table]
    numbers = table[_SENSOR]
    rows_of = [np.flatnonzero(numbers == number) for number in np.unique(numbers)[:_MAX_SENSORS]]
    return [{name: column[rows] for name, column in table.items()} for rows in rows_of]


# Telemetry: MAVLink 1 and 2, each message behind the time of its arrival. Times are the vehicle's own. Messages that
# are asked for are known by their checksum; of others, or of damage, only where they stand is looked at.

# Microseconds since 1970 before each message, the most significant byte first: the years 2000 to 2100.
_STAMP_BYTES: Final = 8
_STAMPS_US: Final = (946_684_800_000_000, 4_102_444_800_000_000)
_MAVLINK_1, _MAVLINK_2 = 0xFE, 0xFD
_FIRST_BYTE: Final = re.compile(rb"[\xfe\xfd]")
# Bytes of a message before its payload, by the first of them.
_TLOG_HEAD_BYTES: Final = {_MAVLINK_1: 6, _MAVLINK_2: 10}
_CHECKSUM_BYTES: Final = 2
# The component that flies; gimbals and cameras have attitudes, too.
_AUTOPILOT: Final = 1
_TLOG_ARMED: Final = 0x80
_REVERSED: Final = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))


class _Kind(NamedTuple):
    """A message: its table, what its checksum ends with, and the numbers in its payload with their factors."""

    table: str
    checksum_end: int
    payload: Struct
    scales: Mapping[str, float]


_DEG: Final = 180 / np.pi
_MILLI_G: Final = dict.fromkeys("xyz", 1e-3 * STANDARD_GRAVITY_M_S2)
_ATTITUDE: Final = 30
_TLOG_KINDS: Final = {
    0: _Kind("HEARTBEAT", 50, Struct("<6xB2x"), {"mode": 1.0}),
    _ATTITUDE: _Kind("ATTITUDE", 39, Struct("<Iff16x"), {TIME: 1e-3, "roll": _DEG, "pitch": _DEG}),
    33: _Kind("GLOBAL_POSITION_INT", 104, Struct("<I12xi8x"), {TIME: 1e-3, "altitude": 1e-3}),
    105: _Kind("IMU", 93, Struct("<Q3f42x"), {TIME: 1e-6, "x": 1.0, "y": 1.0, "z": 1.0}),  # HIGHRES_IMU
    27: _Kind("IMU", 144, Struct("<Q3h12x"), {TIME: 1e-6, **_MILLI_G}),  # RAW_IMU
    26: _Kind("IMU", 170, Struct("<I3h12x"), {TIME: 1e-3, **_MILLI_G}),  # SCALED_IMU
    116: _Kind("IMU", 76, Struct("<I3h12x"), {TIME: 1e-3, **_MILLI_G}),  # SCALED_IMU2
    129: _Kind("IMU", 46, Struct("<I3h12x"), {TIME: 1e-3, **_MILLI_G}),  # SCALED_IMU3
}
_TLOG_TILTS: Final = (ChannelSource("ATTITUDE", ("roll", "pitch"), tilt_of_roll_and_pitch),)
_TLOG_FORCES: Final = (ChannelSource("IMU", ("x", "y", "z"), force_of_axes),)
_TLOG_ALTITUDES: Final = (ChannelSource("GLOBAL_POSITION_INT", ("altitude",)),)
_TLOG_ARMING: Final = (ChannelSource("HEARTBEAT", ("mode",), lambda mode: mode.astype(np.int64) & _TLOG_ARMED),)


def is_telemetry(start: bytes) -> bool:
    """Whether a file that begins so is telemetry of a ground station."""
    stamp_us = int.from_bytes(start[:_STAMP_BYTES], "big")
    return start[_STAMP_BYTES : _STAMP_BYTES + 1] in (b"\xfd", b"\xfe") and _STAMPS_US[0] <= stamp_us <= _STAMPS_US[1]


def _messages(data: bytes) -> Iterator[tuple[int, tuple[int, int], tuple[float, ...]]]:
    """Yields of each message where it ends; its vehicle and number; and, of one that is asked for, when it arrived, and
    the numbers in it."""
    end = 0
    for first in _FIRST_BYTE.finditer(data, _STAMP_BYTES):
        head_at = first.start()
        begin = head_at - _STAMP_BYTES
        head = data[head_at : head_at + _TLOG_HEAD_BYTES[data[head_at]]]
        if begin < end or not is_telemetry(data[begin : head_at + 1]) or len(head) < _TLOG_HEAD_BYTES[head[0]]:
            continue
        payload_at = head_at + len(head)
        payload_end = payload_at + head[1]
        vehicle, component, number = head[3:6]
        if head[0] == _MAVLINK_2:
            vehicle, component, number = head[5], head[6], int.from_bytes(head[7:10], "little")
        kind = _TLOG_KINDS.get(number)
        if kind is None or component != _AUTOPILOT:
            yield payload_end + _CHECKSUM_BYTES, (vehicle, number), ()
            continue
        # MAVLink's checksum is the one of the standard library, which is fast, with the bits of all bytes reversed.
        checked = data[head_at + 1 : payload_end] + bytes((kind.checksum_end,))
        bits = crc_hqx(checked.translate(_REVERSED), 0xFFFF)
        if data[payload_end : payload_end + 2] == bytes((_REVERSED[bits >> 8], _REVERSED[bits & 0xFF])):
            end = payload_end + _CHECKSUM_BYTES
            # MAVLink 2 leaves out zeros at the end of a payload.
            payload = data[payload_at:payload_end].ljust(kind.payload.size, b"\0")
            stamp_us = int.from_bytes(data[begin:head_at], "big")
            yield end, (vehicle, number), (stamp_us * 1e-6, *kind.payload.unpack_from(payload))


def read_telemetry(data: bytes) -> RawLog:
    """Read the one vehicle with an attitude. Raises `UserError` where there are more."""
    found: dict[tuple[int, int], list[tuple[float, ...]]] = {}
    read_until = 0
    for end, source, values in _messages(data):
        read_until = min(end, len(data))
        if values:
            found.setdefault(source, []).append(values)
    vehicles = {vehicle for vehicle, number in found if number == _ATTITUDE}
    if len(vehicles) > 1:
        raise unreadable(marked("more than one vehicle in one file"))
    tables: dict[str, list[Table]] = {}
    for (vehicle, number), rows in found.items():
        stamp_s, *columns = np.array(rows, np.float64).T
        kind = _TLOG_KINDS[number]
        scaled = {one: column * kind.scales[one] for one, column in zip(kind.scales, columns, strict=True)}
        if vehicle in vehicles or not vehicles:
            # Arming has no time of the vehicle.
            tables.setdefault(kind.table, []).append({TIME: stamp_s, "stamp": stamp_s, **scaled})
    # It gets that of the attitude that arrived with it.
    for clock in tables.get("ATTITUDE", ()):
        order = np.argsort(clock["stamp"], kind="stable")
        for beats in tables.get("HEARTBEAT", ()):
            beats[TIME] = np.interp(beats["stamp"], clock["stamp"][order], clock[TIME][order])
    raw = RawLog(tilts_deg=channels_of(tables, _TLOG_TILTS), forces_g=channels_of(tables, _TLOG_FORCES))
    raw.altitudes_m, raw.armed = channels_of(tables, _TLOG_ALTITUDES), channels_of(tables, _TLOG_ARMING)
    raw.note_damage(0, read_until, len(data))
    return raw
