"""Reads PX4's ULog, versions 0 and 1: attitude, acceleration of every sensor, altitude, arming, landing.

https://docs.px4.io/main/en/dev_log/ulog_file_format.html

Finds the samples of the wanted topics. Read without pyulog, which a file of 113 bytes keeps busy without end: see
docs/flight-logs.md.
"""

import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from app.flights.flight_log import Floats, unreadable
from app.flights.raw_log import Channel, FlagChannel, RawLog, force_of_axes, tilt_of_quaternion
from app.flights.records import MAX_DAMAGES, MAX_WALKED, RecordField, RecordTable, read_bytes
from app.text.messages import message
from protocol.translatable import marked

_HEADER_BYTES: Final = 16
_SYNC: Final = b"\x08\x00S\x2f\x73\x13\x20\x25\x0c\xbb\x12"
_KINDS: Final = frozenset(b"BFIMPQARDLCSO")
_DEFINITIONS: Final = frozenset(b"BFIMPQ")
_SAMPLE: Final = ord("D")
_TYPES: Final[Mapping[str, str]] = {
    "int8_t": "<i1", "uint8_t": "<u1", "bool": "<u1", "char": "<u1",
    "int16_t": "<i2", "uint16_t": "<u2", "int32_t": "<i4", "uint32_t": "<u4",
    "int64_t": "<i8", "uint64_t": "<u8", "float": "<f4", "double": "<f8",
}  # fmt: skip
_FIELD: Final = re.compile(r"([A-Za-z_][A-Za-z0-9_/]*)(?:\[(\d{1,5})\])? ([A-Za-z_][A-Za-z0-9_]*)")
_APPENDED: Final = 0x01
"""Incompatible flag of appended data, the only one that is supported."""
MAX_TOPICS: Final = 1000
_DEEPEST: Final = 8
_LARGEST: Final = 0xFFFF
_ID_BYTES: Final = 2
_RECORD_HEAD: Final = 3


@dataclass(slots=True, kw_only=True)
class UlogTopic(RecordTable):
    """One instance of a topic. Elements of arrays are fields such as `q[0]`."""

    instance: int
    layout: "_Layout"


class _Layout(NamedTuple):
    fields: Mapping[str, RecordField]
    size: int
    """Bytes of a sample."""
    least_size: int
    """Without the padding at the end, which is not written."""

    def is_size(self, size: int) -> bool:
        return self.least_size <= size <= self.size


class UlogFile:
    """`topics` has the topics of `TOPICS` in the file. Raises `UserError`."""

    def __init__(self, data: bytes) -> None:
        if len(data) < _HEADER_BYTES:
            raise unreadable(marked("unknown kind of file"))
        self._data = data
        self._formats: dict[str, str] = {}
        self._subscribed: dict[int, UlogTopic] = {}
        self._layouts: dict[str, _Layout | None] = {}
        self._appended: tuple[int, ...] = ()
        self._damages = 0
        self.topics: list[UlogTopic] = []
        self.skipped_bytes = 0
        """Bytes that are not records: damage."""
        self.dropout_s = 0.0
        """Time that the flight controller reports as not logged."""
        self._walk_all()

    def _walk_all(self) -> None:
        place = self._walk(_HEADER_BYTES, len(self._data), is_head=True)
        bounds = [start for start in self._appended if place <= start < len(self._data)]
        for start, stop in zip([place, *bounds], [*bounds, len(self._data)], strict=True):
            self._walk(start, stop)

    def _walk(self, place: int, stop: int, *, is_head: bool = False) -> int:
        """Reads the records; the head ends with the first that is not a definition."""
        data, subscribed = self._data, self._subscribed
        head = struct.Struct("<HBH").unpack_from
        for _ in range(MAX_WALKED):
            if place + _RECORD_HEAD + _ID_BYTES > stop or self._damages > MAX_DAMAGES:
                break
            size, kind, number = head(data, place)
            end = place + _RECORD_HEAD + size
            is_record = kind in _KINDS and end <= stop
            if is_head and not (is_record and kind in _DEFINITIONS):
                break
            topic = subscribed.get(number) if kind == _SAMPLE and is_record else None
            if not is_record or (topic is not None and not topic.layout.is_size(size - _ID_BYTES)):
                place = self._resync(place, stop)
                continue
            if topic is not None:
                topic.places.append(place + _RECORD_HEAD + _ID_BYTES)
            elif kind != _SAMPLE:
                self._read(kind, data[place + _RECORD_HEAD : end])
            place = end
        return place

    def _resync(self, place: int, stop: int) -> int:
        """Offset of the next sync record."""
        next_place = self._data.find(_SYNC, place + 1, stop)
        next_place = stop if next_place < 0 else next_place
        self.skipped_bytes += next_place - place
        self._damages += 1
        return next_place

    def _read(self, kind: int, body: bytes) -> None:
        match chr(kind):
            case "B" if len(body) >= 40:
                unknown = body[8] & ~_APPENDED or any(body[9:16])
                if unknown:
                    raise unreadable(marked("written by a newer version"))
                self._appended = tuple(sorted(start for start in struct.unpack_from("<3Q", body, 16) if start))
            case "F":
                name, _, fields = body.decode("latin-1").partition(":")
                self._formats[name] = fields
            case "A" if len(body) > 3:
                self._subscribe(body[0], int.from_bytes(body[1:3], "little"), body[3:].decode("latin-1"))
            case "O" if len(body) >= 2:
                self.dropout_s += int.from_bytes(body[:2], "little") / 1000
            case _:
                pass

    def _subscribe(self, instance: int, number: int, name: str) -> None:
        self._subscribed.pop(number, None)
        if name not in TOPICS or len(self.topics) >= MAX_TOPICS or (layout := self._layout(name)) is None:
            return
        topic = UlogTopic(name, self._data, layout.fields, instance=instance, layout=layout)
        self._subscribed[number] = topic
        self.topics.append(topic)

    def _layout(self, name: str, depth: int = 0) -> _Layout | None:
        """Layout of a topic, cached; None where its format is invalid."""
        if name not in self._layouts:
            is_known = name in self._formats and depth <= _DEEPEST
            self._layouts[name] = self._make_layout(name, depth) if is_known else None
        return self._layouts[name]

    def _make_layout(self, name: str, depth: int) -> _Layout | None:
        fields: dict[str, RecordField] = {}
        offset = least = 0
        for text in self._formats[name].split(";"):
            if not text:
                continue
            match = _FIELD.fullmatch(text)
            if match is None:
                return None
            kind, count, label = match[1], int(match[2] or 1), match[3]
            if kind in _TYPES:
                size = np.dtype(_TYPES[kind]).itemsize
                for number in range(count if kind != "char" and count <= 32 else 0):
                    key = label if match[2] is None else f"{label}[{number}]"
                    fields[key] = RecordField(offset + number * size, _TYPES[kind])
            else:
                nested = self._layout(kind, depth + 1)
                if nested is None:
                    return None
                size = nested.size
            offset += size * count
            if offset > _LARGEST:
                return None
            if not label.startswith("_padding"):
                least = offset
        return _Layout(fields, offset, least)


TOPICS: Final = frozenset(
    {
        "vehicle_attitude", "sensor_combined", "vehicle_acceleration", "vehicle_imu", "sensor_accel",
        "vehicle_local_position", "vehicle_air_data", "vehicle_status", "vehicle_land_detected",
    }
)  # fmt: skip
ARMED: Final = 2
"""vehicle_status.arming_state."""
_MICROSECOND: Final = 1e-6
_MAX_SENSORS: Final = 6


def read_ulog(path: Path) -> RawLog:
    """Raises `UserError`, OSError."""
    file = UlogFile(read_bytes(path))
    raw = RawLog(name=str(path))
    for topic in sorted(file.topics, key=lambda topic: topic.instance):
        if topic.has("timestamp"):
            _read_topic(topic, raw)
    raw.forces_g = [*_forces(file)][:_MAX_SENSORS]
    if file.skipped_bytes:
        raw.problems.append(message(marked("Damaged; bytes left out: {count}."), count=f"{file.skipped_bytes:,}"))
    if file.dropout_s:
        raw.problems.append(message(marked("Nothing logged for {seconds:.2f} s."), seconds=file.dropout_s))
    return raw


def _read_topic(topic: UlogTopic, raw: RawLog) -> None:
    time_s = _times(topic)
    match topic.name:
        case "vehicle_attitude" if topic.has("q[0]", "q[1]", "q[2]", "q[3]"):
            tilt_deg = tilt_of_quaternion(*(topic.column(f"q[{number}]") for number in range(4)))
            raw.tilts_deg.append(Channel(time_s, tilt_deg))
        case "vehicle_local_position" if topic.has("z"):
            raw.altitude_m = Channel(time_s, -topic.column("z"))
        case "vehicle_air_data" if topic.has("baro_alt_meter") and raw.altitude_m is None:
            raw.altitude_m = Channel(time_s, topic.column("baro_alt_meter"))
        case "vehicle_land_detected" if topic.has("landed"):
            raw.on_ground = FlagChannel(time_s, topic.column("landed") != 0)
        case "vehicle_status" if topic.has("arming_state"):
            raw.armed = FlagChannel(time_s, topic.column("arming_state") == ARMED)
        case _:
            pass


def _times(topic: UlogTopic) -> Floats:
    return topic.column("timestamp") * _MICROSECOND


def _forces(file: UlogFile) -> list[Channel]:
    """The estimator's acceleration first, then each sensor."""
    channels: list[Channel] = []
    for name, labels in (
        ("sensor_combined", [f"accelerometer_m_s2[{axis}]" for axis in range(3)]),
        ("vehicle_acceleration", [f"xyz[{axis}]" for axis in range(3)]),
        ("vehicle_imu", [f"delta_velocity[{axis}]" for axis in range(3)]),
        ("sensor_accel", ["x", "y", "z"]),
    ):
        topics = [topic for topic in file.topics if topic.name == name and topic.has("timestamp", *labels)]
        if channels and name == "vehicle_acceleration":
            continue  # the same sensor, filtered
        if name == "sensor_accel" and len(channels) > 1:
            continue  # vehicle_imu has them all
        for topic in sorted(topics, key=lambda topic: topic.instance):
            axes = [topic.column(label) for label in labels]
            if name == "vehicle_imu":
                axes = _over_time(topic, axes)
            channels.append(Channel(_times(topic), force_of_axes(*axes)))
    return channels


def _over_time(topic: UlogTopic, axes: list[Floats]) -> list[Floats]:
    """Acceleration from changes of velocity; NaN where their duration is unknown."""
    if not topic.has("delta_velocity_dt"):
        return [np.full_like(axis, np.nan) for axis in axes]
    took_s = topic.column("delta_velocity_dt") * _MICROSECOND
    took_s[took_s <= 0] = np.nan
    return [axis / took_s for axis in axes]
