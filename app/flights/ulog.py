"""Reads PX4's ULog, versions 0 and 1: attitude, acceleration of every sensor, altitude, arming.

https://docs.px4.io/main/en/dev_log/ulog_file_format.html

A record is the size of its body in two bytes, its kind in one, and its body. Formats (`F`), subscriptions (`A`) and
samples (`D`) are known by what is in them, wherever they stand: damage costs the damaged records, and sync records,
which many files have not, are not needed. Read without pyulog, which a file of 113 bytes keeps busy without end: see
docs/flight-logs.md.
"""

import re
from collections.abc import Iterator, Mapping
from itertools import chain
from typing import Final

import numpy as np

from app.flights.raw_log import (
    AT_ONCE,
    TIME,
    ChannelSource,
    Floats,
    Layout,
    Places,
    RawLog,
    Table,
    channels_of,
    columns_of,
    force_of_axes,
    tilt_of_quaternion,
    unreadable,
)
from protocol.translatable import marked

_HEADER_BYTES: Final = 16
_RECORD_HEAD: Final = 3
_ID_BYTES: Final = 2
_KINDS: Final = frozenset(b"BFIMPQARDLCSO")
_TYPES: Final[Mapping[str, str]] = {
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
_ARMED: Final = 2
_MAX_SENSORS: Final = 6


def _axes(name: str) -> tuple[str, str, str]:
    return f"{name}[0]", f"{name}[1]", f"{name}[2]"


def _force_of_changes(x_m_s: Floats, y_m_s: Floats, z_m_s: Floats, took_us: Floats) -> Floats:
    """Of changes of velocity, and how long each took."""
    took_s = np.where(took_us > 0, took_us * 1e-6, np.nan)
    return force_of_axes(x_m_s / took_s, y_m_s / took_s, z_m_s / took_s)


_TILTS: Final = (ChannelSource("vehicle_attitude", ("q[0]", "q[1]", "q[2]", "q[3]"), tilt_of_quaternion),)
# What the estimator uses, and each sensor; of both the first that is there.
_ESTIMATOR_FORCES: Final = (
    ChannelSource("sensor_combined", _axes("accelerometer_m_s2"), force_of_axes),
    ChannelSource("vehicle_acceleration", _axes("xyz"), force_of_axes),
)
_SENSOR_FORCES: Final = (
    ChannelSource("vehicle_imu", (*_axes("delta_velocity"), "delta_velocity_dt"), _force_of_changes),
    ChannelSource("sensor_accel", ("x", "y", "z"), force_of_axes),
)
_ALTITUDES: Final = (
    ChannelSource("vehicle_local_position", ("z",), np.negative),
    ChannelSource("vehicle_air_data", ("baro_alt_meter",)),
)
_ARMING: Final = (ChannelSource("vehicle_status", ("arming_state",), lambda state: state == _ARMED),)
_SOURCES: Final = (*_TILTS, *_ESTIMATOR_FORCES, *_SENSOR_FORCES, *_ALTITUDES, *_ARMING)
# The columns of each topic that is asked for.
_WANTED: Final = {one.table: {TIME: 1e-6} | dict.fromkeys(one.columns, 1.0) for one in _SOURCES}


class UlogFile:
    """Raises `UserError`."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._bytes = np.frombuffer(data, np.uint8)
        self._formats: dict[str, str] = {}
        self._layouts: dict[str, Layout | None] = {}
        # By name, an instance of a topic each.
        self.topics: dict[str, list[Table]] = {}
        # Bytes that are no records: damage.
        self.skipped_bytes = 0
        # Where the last record ends.
        self.read_until = _HEADER_BYTES
        self._refuse_newer_versions()
        for begin, end in chain(*self._found("F", _LONGEST_FORMAT)):
            match = _FORMAT.fullmatch(data, begin + _RECORD_HEAD, end)
            if match is not None:
                self._formats.setdefault(match[1].decode(), match[2].decode())
        # A subscription gives a topic and its instance the number that stands in their samples.
        subscribed: dict[int, tuple[str, int]] = {}
        for begin, end in chain(*self._found("A", _LONGEST_NAME)):
            instance, number, name = (
                data[begin + 3],
                data[begin + 4 : begin + 6],
                data[begin + 6 : end].decode("latin-1"),
            )
            if name in self._formats:
                subscribed.setdefault(int.from_bytes(number, "little"), (name, instance))
        self._read_samples(subscribed)

    def _refuse_newer_versions(self) -> None:
        """Version 1 begins with its flags, of which the second eight bytes say what a reader must understand."""
        flags = self._data[_HEADER_BYTES + _RECORD_HEAD + 8 : _HEADER_BYTES + _RECORD_HEAD + 16]
        has_flags = self._data[_HEADER_BYTES + 2 : _HEADER_BYTES + 3] == b"B" and len(flags) > 0
        if has_flags and (flags[0] & ~_APPENDED or any(flags[1:])):
            raise unreadable(marked("written by a newer version"))

    def _found(self, kind: str, longest: int) -> Iterator[Places]:
        """Where records of a kind may begin and end, shape (number, 2), in one part of the file after the other."""
        for first in range(_HEADER_BYTES, len(self._data), AT_ONCE):
            begins = np.flatnonzero(self._bytes[first + 2 : first + 2 + AT_ONCE] == ord(kind)) + first
            sizes = self._numbers_at(begins)
            ends = begins + _RECORD_HEAD + sizes
            fits = (sizes > _ID_BYTES) & (sizes <= longest) & (ends <= len(self._data))
            yield np.column_stack((begins[fits], ends[fits]))

    def _numbers_at(self, places: Places) -> Places:
        """Numbers of two bytes."""
        numbers: Places = self._bytes[places] + 256 * self._bytes[places + 1].astype(np.int64)
        return numbers

    def _read_samples(self, subscribed: Mapping[int, tuple[str, int]]) -> None:
        # What a sample may have at least and at most, by its number: padding at its end is not written.
        least, most = np.ones(_LARGEST + 1, np.int64), np.zeros(_LARGEST + 1, np.int64)
        for number, (name, _) in subscribed.items():
            layout = self._layout(name)
            if layout is not None:
                most[number] = least[number] = _RECORD_HEAD + _ID_BYTES + layout.itemsize
                if (layout.names or ("",))[-1].startswith(_PADDING):
                    least[number] -= layout[-1].itemsize
        parts = [np.empty((0, 2), np.int64)]
        for part in self._found("D", _LARGEST):
            sizes, numbers = part[:, 1] - part[:, 0], self._numbers_at(part[:, 0] + _RECORD_HEAD)
            parts.append(part[(least[numbers] <= sizes) & (sizes <= most[numbers])])
        samples = np.concatenate(parts)
        numbers = self._numbers_at(samples[:, 0] + _RECORD_HEAD)
        for number, (name, _) in sorted(subscribed.items(), key=lambda one: one[1]):
            layout = self._layout(name)
            if name in _WANTED and layout is not None:
                places = samples[numbers == number, 0] + _RECORD_HEAD + _ID_BYTES
                table = columns_of(self._data, layout, places, _WANTED[name])
                if table:
                    self.topics.setdefault(name, []).append(table)
        self._read_between(samples)

    def _read_between(self, samples: Places) -> None:
        """Between samples there are whole other records, or damage."""
        bounds = np.concatenate(((0, _HEADER_BYTES), samples.ravel(), (len(self._data),) * 2)).reshape(-1, 2)
        for row in np.flatnonzero(bounds[1:, 0] > bounds[:-1, 1]).tolist():
            place, stop = int(bounds[row, 1]), int(bounds[row + 1, 0])
            while place + _RECORD_HEAD < stop:
                size, kind = int.from_bytes(self._data[place : place + 2], "little"), self._data[place + 2]
                end = place + _RECORD_HEAD + size
                if end > stop or size == 0 or kind not in _KINDS:
                    break
                place = end
            self.skipped_bytes += stop - place
            self.read_until = place
        if bounds[-1, 0] == bounds[-2, 1]:
            self.read_until = len(self._data)

    def _layout(self, name: str) -> Layout | None:
        """The layout of a topic; None where its format is unknown or not understood."""
        if name not in self._layouts:
            self._layouts[name] = self._make_layout(self._formats.get(name, ""))
        return self._layouts[name]

    def _make_layout(self, fields: str) -> Layout | None:
        """An element of an array is a field like `q[0]`. No topic that is read has formats within its format."""
        parts: list[tuple[str, object]] = []
        size = 0
        for text in fields.rstrip(";").split(";"):
            match = _FIELD.fullmatch(text)
            if match is None or match[1] not in _TYPES:
                return None
            name, count, label = match.groups()
            kind = np.dtype(_TYPES[name])
            size += kind.itemsize * int(count or 1)
            if size > _LARGEST:
                return None
            if count is None:
                parts.append((TIME if label == "timestamp" else label, kind))
            elif int(count) <= _MOST_ELEMENTS and not label.startswith(_PADDING):
                parts += [(f"{label}[{number}]", kind) for number in range(int(count))]
            else:
                parts.append((label, (kind, int(count))))
        try:
            return np.dtype(parts)
        except ValueError:  # two fields of one name
            return None


def read_ulog(data: bytes, name: str) -> RawLog:
    """Raises `UserError`."""
    file = UlogFile(data)
    raw = RawLog(name=name, tilts_deg=channels_of(file.topics, _TILTS))
    for sources in (_ESTIMATOR_FORCES, _SENSOR_FORCES):
        there = [source for source in sources if source.table in file.topics]
        raw.forces_g += channels_of(file.topics, there[:1])
    del raw.forces_g[_MAX_SENSORS:]
    raw.altitudes_m = channels_of(file.topics, _ALTITUDES)
    raw.armed = channels_of(file.topics, _ARMING)
    raw.note_damage(file.skipped_bytes, file.read_until, len(data))
    return raw
