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
from app.flights.records import MAX_WALKED, RecordField, RecordTable, read_bytes
from app.text.messages import message
from protocol.translatable import marked

_HEADER_BYTES: Final = 16
_SAMPLE: Final = ord("D")
_DEFINITIONS: Final = frozenset(b"BFIMPQ")
_KINDS: Final = frozenset(b"BFIMPQARDLCSO")
_FIXED_SIZES: Final = {ord("S"): 8, ord("R"): 2, ord("O"): 2}
"""Sizes of the records that have always the same."""
_KIND_BYTE: Final = re.compile(rb"[BFIMPQARDLCSO]")
_RECORD_HEAD: Final = 3
"""Bytes of a record before its body: the size of the body, and the kind."""
_ID_BYTES: Final = 2
MAX_SEARCHED: Final = 1 << 26
"""Bytes of damage that are searched for the next record; what follows is not read."""
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


@dataclass(slots=True, kw_only=True)
class UlogTopic(RecordTable):
    """One instance of a topic. Elements of arrays are fields such as `q[0]`."""

    instance: int


class _Layout(NamedTuple):
    fields: Mapping[str, RecordField]
    size: int
    """Bytes of a sample."""
    least_size: int
    """Without the padding at the end, which is not written."""


class _Subscription(NamedTuple):
    """What a sample with one number must look like. `topic` is None where nobody asks for it."""

    least_size: int
    size: int
    topic: UlogTopic | None


class UlogFile:
    """`topics` has the topics of `TOPICS` in the file. Raises `UserError`.

    Damage costs the damaged record: the next one is found by what a record of this file must look like. Sync records
    are not needed, which many files have not.
    """

    def __init__(self, data: bytes) -> None:
        if len(data) < _HEADER_BYTES:
            raise unreadable(marked("unknown kind of file"))
        self.data = data
        self._formats: dict[str, str] = {}
        self._subscribed: dict[int, _Subscription] = {}
        self._layouts: dict[str, _Layout | None] = {}
        self._appended: tuple[int, ...] = ()
        self._searched = 0
        self.topics: list[UlogTopic] = []
        self.skipped_bytes = 0
        """Bytes that are not records: damage."""
        self.lost_end_bytes = 0
        """Those of them at the end of the file."""
        self.dropout_s = 0.0
        """Time that the flight controller reports as not logged."""
        self._walk_all()

    def _walk_all(self) -> None:
        place = self._walk(_HEADER_BYTES, len(self.data), is_head=True)
        bounds = [start for start in self._appended if place <= start < len(self.data)]
        for start, stop in zip([place, *bounds], [*bounds, len(self.data)], strict=True):
            self._walk(start, stop)

    def _walk(self, place: int, stop: int, *, is_head: bool = False) -> int:
        """Reads the records; the head ends with the first that is not a definition."""
        data, subscribed = self.data, self._subscribed
        head = struct.Struct("<HBH").unpack_from
        # Where the last record begins, unless its size is that of its topic: a damaged size leads astray.
        doubtful: int | None = None
        self.lost_end_bytes = 0
        for _ in range(MAX_WALKED):
            if place + _RECORD_HEAD + _ID_BYTES > stop:
                break
            size, kind, number = head(data, place)
            if kind == _SAMPLE and not is_head:
                subscription = subscribed.get(number)
                end = place + _RECORD_HEAD + size
                if subscription is not None and end <= stop:
                    least_size, most_size, topic = subscription
                    if least_size <= size - _ID_BYTES <= most_size:
                        if topic is not None:
                            topic.places.append(place + _RECORD_HEAD + _ID_BYTES)
                        doubtful = None
                        place = end
                        continue
            next_place = self._end_of_record(place, stop)
            if is_head and (next_place is None or kind not in _DEFINITIONS):
                return place
            if next_place is None:
                begin = place if doubtful is None else doubtful
                doubtful = None
                next_place = self._next_record(begin + 1, stop)
                self.skipped_bytes += next_place - begin
                if next_place == stop:
                    self.lost_end_bytes = stop - begin
            else:
                self._read(kind, data[place + _RECORD_HEAD : next_place])
                doubtful = place
            place = next_place
        if place < stop and not is_head:
            self.skipped_bytes += stop - place
            self.lost_end_bytes += stop - place
        return place

    def _end_of_record(self, place: int, stop: int) -> int | None:
        """Where the record at this place ends; None where there cannot be one."""
        if place + _RECORD_HEAD + 1 > stop:
            return None
        size, kind = struct.unpack_from("<HB", self.data, place)
        end: int = place + _RECORD_HEAD + size
        if end > stop or size == 0 or kind not in _KINDS or size != _FIXED_SIZES.get(kind, size):
            return None
        return None if kind == _SAMPLE and not self._is_sample(place, size) else end

    def _is_sample(self, place: int, size: int) -> bool:
        if size < _ID_BYTES:
            return False
        (number,) = struct.unpack_from("<H", self.data, place + _RECORD_HEAD)
        subscription = self._subscribed.get(number)
        return subscription is not None and subscription.least_size <= size - _ID_BYTES <= subscription.size

    def _next_record(self, begin: int, stop: int) -> int:
        """The first place from `begin` on at which a record begins; `stop` where there is none."""
        for match in _KIND_BYTE.finditer(self.data, begin + _RECORD_HEAD - 1, stop):
            place = match.start() - (_RECORD_HEAD - 1)
            self._searched += 1
            if self._searched > MAX_SEARCHED:
                break
            end = self._end_of_record(place, stop)
            if end is None:
                continue
            # A sample is known by its topic and size; of other records the next one has to be there, too.
            if self.data[place + _RECORD_HEAD - 1] == _SAMPLE or end == stop:
                return place
            if self._end_of_record(end, stop) is not None:
                return place
        return stop

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
        layout = self._layout(name)
        if layout is None:
            # A format that is not understood: a sample of any size may be one.
            self._subscribed[number] = _Subscription(0, _LARGEST, None)
            return
        topic: UlogTopic | None = None
        if name in TOPICS and len(self.topics) < MAX_TOPICS:
            topic = UlogTopic(name, self.data, layout.fields, instance=instance)
            self.topics.append(topic)
        self._subscribed[number] = _Subscription(layout.least_size, layout.size, topic)

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
        raw.lost_end_s = raw.seconds_of(file.lost_end_bytes, len(file.data))
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
