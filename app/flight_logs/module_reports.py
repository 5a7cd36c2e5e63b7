"""Reads flights measured by a module: recordings of this program, as folders and as MCAP."""

import json
import struct
import zlib
from array import array
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

import numpy as np

from app.flight_logs.assembly import MAX_ROWS, Reports, flight_of_reports
from app.flight_logs.flight_log import FlightLog, Floats, LogFormat, unreadable
from app.flight_logs.records import read_bytes
from app.recordings.file_layout import Unreadable
from app.recordings.markers import STATE_LOST
from app.text.messages import UserMessage, message
from protocol.translatable import marked

MCAP_MAGIC: Final = b"\x89MCAP0\r\n"
MAX_CHUNK_BYTES: Final = 1 << 26
MAX_UNPACKED_BYTES: Final = 1 << 30
_CHANNEL, _MESSAGE, _CHUNK, _DATA_END, _FOOTER = 0x04, 0x05, 0x06, 0x0F, 0x02
_RECORD_HEAD: Final = 9
_NANOSECOND: Final = 1e-9


def read_recording(folder: Path) -> FlightLog:
    """Raises `LogUnreadable`."""
    from app.recordings.recording import RecordingUnreadable, open_recording

    try:
        with open_recording(folder) as recording:
            excerpt = recording.excerpt(recording.start_s, recording.end_s)
            reports = Reports(
                np.array(excerpt.time_s, np.float64),
                np.array(excerpt.tilt_deg, np.float64),
                np.array(excerpt.acceleration_g, np.float64),
                tuple(one.time_s for one in excerpt.markers if one.kind in STATE_LOST),
            )
            is_damaged = recording.damage is not None
    except RecordingUnreadable as error:
        cause = error.__cause__
        raise unreadable(str(cause) if isinstance(cause, Unreadable) else marked("cannot be read")) from error
    problems = [message(marked("A damaged part is left out."))] if is_damaged else []
    return flight_of_reports(str(folder), LogFormat.RECORDING, reports, problems)


# MCAP, as this program writes it: https://mcap.dev/spec


def read_mcap(path: Path) -> FlightLog:
    """Raises `LogUnreadable`, OSError."""
    data = read_bytes(path)
    if not data.startswith(MCAP_MAGIC):
        raise unreadable(marked("unknown kind of file"))
    reader = _McapReader()
    reader.read(data)
    if not reader.topics.keys() & {"/status"}:
        raise unreadable(marked("unknown kind of file"))
    return flight_of_reports(str(path), LogFormat.MCAP, reader.reports(), reader.problems)


class _McapReader:
    """Reads a whole file without its indexes; time and memory are bounded."""

    def __init__(self) -> None:
        self.topics: dict[str, int] = {}
        self.problems: list[UserMessage] = []
        self._times_ns, self._tilts, self._accelerations = array("Q"), array("d"), array("d")
        self._resets_ns: list[int] = []
        self._unpacked = 0
        self._unread = 0

    def reports(self) -> Reports:
        if self._unread:
            self.problems.append(message(marked("Invalid samples left out: {count}."), count=f"{self._unread:,}"))
        start = self._times_ns[0] if self._times_ns else 0
        since_ns = np.frombuffer(self._times_ns, np.uint64) - np.uint64(start)  # earlier times wrap around
        time_s: Floats = np.multiply(since_ns.astype(np.int64), _NANOSECOND, dtype=np.float64)
        return Reports(
            time_s,
            np.frombuffer(self._tilts),
            np.frombuffer(self._accelerations),
            tuple((one - start) * _NANOSECOND for one in self._resets_ns),
        )

    def read(self, data: bytes) -> None:
        is_ended = False
        for kind, body in self._records(data, len(MCAP_MAGIC)):
            if kind in (_DATA_END, _FOOTER):
                is_ended = True
                break
            if kind == _CHUNK:
                self._read_chunk(body)
            else:
                self._read_record(kind, body)
        if not is_ended:
            self.problems.append(message(marked("cut off")))

    def _records(self, data: bytes, place: int) -> Iterator[tuple[int, bytes]]:
        while place + _RECORD_HEAD <= len(data):
            kind = data[place]
            length = int.from_bytes(data[place + 1 : place + _RECORD_HEAD], "little")
            place += _RECORD_HEAD
            if place + length > len(data):
                return
            yield kind, data[place : place + length]
            place += length

    def _read_chunk(self, body: bytes) -> None:
        unpacked = self._unpack(body)
        if unpacked is None:
            self.problems.append(message(marked("A damaged part is left out.")))
            return
        for kind, record in self._records(unpacked, 0):
            self._read_record(kind, record)

    def _unpack(self, body: bytes) -> bytes | None:
        import zstandard

        try:
            _, _, size, checksum, name_length = struct.unpack_from("<QQQII", body)
            compression = body[32 : 32 + name_length]
            (length,) = struct.unpack_from("<Q", body, 32 + name_length)
        except struct.error:
            return None
        packed = body[40 + name_length : 40 + name_length + length]
        self._unpacked += size
        if size > MAX_CHUNK_BYTES or self._unpacked > MAX_UNPACKED_BYTES or len(packed) != length:
            return None
        if compression == b"zstd":
            try:
                with zstandard.ZstdDecompressor(max_window_size=MAX_CHUNK_BYTES).stream_reader(packed) as stream:
                    packed = stream.read(size + 1)
            except zstandard.ZstdError:
                return None
        elif compression:
            return None
        is_whole = len(packed) == size and checksum in (0, zlib.crc32(packed))
        return packed if is_whole else None

    def _read_record(self, kind: int, body: bytes) -> None:
        if kind == _CHANNEL and len(body) >= 8:
            length = int.from_bytes(body[4:8], "little")
            topic = body[8 : 8 + min(length, 256)].decode("utf-8", "replace")
            self.topics[topic] = int.from_bytes(body[:2], "little")
        elif kind == _MESSAGE and len(body) >= 22:
            channel, _, at_ns = struct.unpack_from("<HIQ", body)
            if channel == self.topics.get("/status"):
                self._read_status(at_ns, _fields(body[22:]))
            elif channel == self.topics.get("/events") and _fields(body[22:]).get("event") in _STATE_LOST_WORDS:
                self._resets_ns.append(at_ns)

    def _read_status(self, at_ns: int, fields: Mapping[str, object]) -> None:
        values = [fields.get(key) for key in ("tilt_deg", "acceleration_g")]
        numbers = [float(one) for one in values if isinstance(one, float | int) and abs(one) < _LARGEST_VALUE]
        if len(numbers) == len(values) and len(self._tilts) < MAX_ROWS:
            self._times_ns.append(at_ns)
            self._tilts.append(numbers[0])
            self._accelerations.append(numbers[1])
        else:
            self._unread += 1


_LARGEST_VALUE: Final = 1e6
_STATE_LOST_WORDS: Final = frozenset(one.value for one in STATE_LOST)


def _fields(text: bytes) -> Mapping[str, object]:
    """Plain values of a JSON object; others by their type's name. Empty for anything but an object."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    if not isinstance(found, dict):
        return {}
    return {key: value if isinstance(value, float | int | str) else str(type(value)) for key, value in found.items()}
