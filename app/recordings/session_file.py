"""The file of a recording: MCAP, as docs/recording.md describes it for other programs.

    metadata "dps-s recording"   where, when and by whom it was recorded; never changes
    metadata "dps-s state"       how far it is; of a fixed length, so it is written again in its place
    /line/rx, /line/tx           the bytes of each read and of each write
    /status                      the module's reports
    /events                      marks, names, limits, polled values

What the list of recordings shows is in the two records at the head of the file: ten thousand files are listed within a
second, and a file that was cut off tells as much as one that was closed.
"""

import json
import os
import struct
import zlib
from collections.abc import Iterator
from contextlib import suppress
from datetime import datetime
from io import BytesIO
from pathlib import Path
from typing import IO, Annotated, Final, TypeVar

import msgspec
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.exceptions import EndOfFile, McapError
from mcap.records import Channel, Chunk, DataEnd, Footer, Header, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import MCAP0_MAGIC
from msgspec import Meta

from app.captures.traffic import CaptureEntry
from app.system.files import lock, private_opener
from app.text.messages import UserError, UserMessage, message
from protocol.messages import Direction
from protocol.translatable import marked

SUFFIX: Final = ".mcap"
OPENING: Final = "dps-s recording"
STATE: Final = "dps-s state"
VERSION: Final = 2
RX, TX, EVENTS, STATUS = "/line/rx", "/line/tx", "/events", "/status"
POLLED: Final = ("cell_voltage_v", "light_v", "charging")
NANOSECONDS: Final = 1_000_000_000
# In these are the opening and the state.
HEAD_BYTES: Final = 8192
# Characters of the state's JSON; with more names the last ones are left out.
STATE_LENGTH: Final = 2000
# A chunk ends with `flush`; where the disk was slow, it ends earlier.
FULL_CHUNK_BYTES: Final = 1 << 22
MAX_CHUNK_BYTES: Final = 1 << 26
# Of a file: eight hours at full line rate. Nothing is read beyond.
MAX_UNPACKED_BYTES: Final = 1 << 32
_YEARS: Final = range(1970, 2201)
# What the libraries raise for damaged bytes.
_DAMAGES: Final = (McapError, zstandard.ZstdError, struct.error, ValueError, OverflowError, MemoryError)

Count = Annotated[int, Meta(ge=0, le=1 << 40)]
# Also seconds of the program's clock: thirty years.
Number = Annotated[float, Meta(ge=-1e9, le=1e9)]


class Opening(msgspec.Struct, frozen=True, kw_only=True):
    """The head of a recording: what is known when it begins. `start_s` is of the program's clock; `started_at` is the
    same moment."""

    started_at: Annotated[datetime, Meta(tz=True)]
    start_s: Number
    port: str
    baud_rate: Count
    program: str = ""
    version: int = VERSION

    def __post_init__(self) -> None:
        """Raises ValueError for a date that no recording has."""
        if self.started_at.year not in _YEARS:
            raise ValueError("no time of a recording")

    @property
    def wall_offset_ns(self) -> int:
        """Nanoseconds since 1970 minus those of the program's clock; whole microseconds."""
        return round((self.started_at.timestamp() - self.start_s) * 1e6) * 1000

    @property
    def start_ns(self) -> int:
        return round(self.start_s * NANOSECONDS) + self.wall_offset_ns

    def clock_s(self, wall_ns: int) -> float:
        return (wall_ns - self.wall_offset_ns) / NANOSECONDS


class State(msgspec.Struct, kw_only=True):
    """How far the recording is."""

    end_s: Number
    reports: Count = 0
    was_triggered: bool = False
    modules: tuple[str, ...] = ()  # The names that were said while it was recorded, in this order
    is_ended: bool = False  # It was closed properly


class RecordedReport(msgspec.Struct, frozen=True, gc=False):
    """A message of `STATUS`; names include the unit, as in all files of the program."""

    tilt_deg: Annotated[float, Meta(ge=0, le=1000)]
    acceleration_g: Annotated[float, Meta(ge=0, le=1000)]
    triggered: bool
    active: bool


class RecordedEvent(msgspec.Struct, frozen=True, kw_only=True):
    """A message of `EVENTS`. What a mark, a name, limits or a reading does not have is left out."""

    event: str = ""
    port: str = ""
    module: str = ""
    fires_deg: Number | None = None
    rearms_deg: Number | None = None
    free_fall_g: Number | None = None
    free_fall_s: Number | None = None
    light_v: Number | None = None  # Of limits, and of a reading
    cell_voltage_v: Number | None = None
    charging: Number | None = None


# The records at the head

Head = TypeVar("Head", Opening, State)


def metadata_record(name: str, head: Opening | State) -> bytes:
    """The MCAP record of an opening or a state."""
    # ASCII, so that the length in bytes does not depend on the names, which may have bytes that are no text.
    text = json.dumps(msgspec.to_builtins(head))
    if isinstance(head, State):
        if len(text) > STATE_LENGTH:
            return metadata_record(name, msgspec.structs.replace(head, modules=head.modules[:-1]))
        text = text.ljust(STATE_LENGTH)
    return _records(Metadata(name, {"json": text, "crc32": _checksum(text)}))


def _checksum(text: str) -> str:
    # MCAP has none for metadata.
    return f"{zlib.crc32(text.encode()):08x}"


def _records(*records: McapRecord) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    raw: bytes = builder.end()  # type: ignore[no-untyped-call]
    return raw


def _head_of(record: Metadata, kind: type[Head]) -> Head:
    text = record.metadata.get("json", "")
    try:
        if record.metadata.get("crc32") != _checksum(text):
            raise ValueError("the checksum is wrong")
        plain = json.loads(text)
        if kind is Opening and plain["version"] != VERSION:
            raise UserError(marked("written by another version"))
        return msgspec.convert(plain, kind)
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        raise UserError(marked("damaged")) from error


def read_head(path: Path) -> tuple[Opening, State]:
    """Read where and when it was recorded, and how far. Raises OSError, `UserError`."""
    with path.open("rb", buffering=0) as file:
        head = file.read(HEAD_BYTES)
    found: dict[str, Metadata] = {}
    with suppress(*_DAMAGES):
        for record in StreamReader(BytesIO(head), emit_chunks=True, record_size_limit=HEAD_BYTES).records:
            if isinstance(record, Metadata):
                found[record.name] = record
                if record.name == STATE:
                    break
    if OPENING not in found:
        raise UserError(marked("not a recording by this program"))
    opening = _head_of(found[OPENING], Opening)
    with suppress(KeyError, UserError):  # the power may have failed while the state was written
        return opening, _head_of(found[STATE], State)
    return opening, State(end_s=opening.start_s)


# Writing

_CHANNELS: Final = {topic: number for number, topic in enumerate((RX, TX, EVENTS, STATUS), 1)}
_SCHEMAS: Final = msgspec.json.schema_components([RecordedEvent, RecordedReport])[1]
# The description of all topics, for other programs, at the begin of the first chunk.
_CHANNEL_RECORDS: Final = _records(
    *(Channel(_CHANNELS[topic], topic, "bytes", {}, 0) for topic in (RX, TX)),
    *(
        Schema(_CHANNELS[topic], msgspec.json.encode(_SCHEMAS[name]), SchemaEncoding.JSONSchema, name)
        for topic, name in ((EVENTS, "RecordedEvent"), (STATUS, "RecordedReport"))
    ),
    *(Channel(_CHANNELS[topic], topic, MessageEncoding.JSON, {}, _CHANNELS[topic]) for topic in (EVENTS, STATUS)),
)


class SessionWriter:
    """Methods raise OSError where the disk fails; what was flushed before stays readable."""

    def __init__(self, path: Path, opening: Opening) -> None:
        self.path = path
        self.opening = opening
        # Written by `flush`; its end is that of what was added.
        self.state = State(end_s=opening.start_s)
        self._offset_ns = opening.wall_offset_ns
        # The next chunk, and the times in it. mcap's own writer would keep an index of all chunks in memory.
        self._chunk = RecordBuilder()
        self._chunk.write(_CHANNEL_RECORDS)
        self._times_ns: list[int] = []
        self._unpacked_bytes = 0
        self._file: IO[bytes] = open(path, "xb", opener=private_opener)  # noqa: SIM115
        try:
            with suppress(OSError):  # a file system without locks; nobody else can hold a file that is new
                lock(self._file)
            self._file.write(MCAP0_MAGIC + _records(Header("", "DPS-S Configurator")))
            self._file.write(metadata_record(OPENING, opening))
            self._state_at = self._file.tell()
            self._file.write(metadata_record(STATE, self.state))
        except BaseException:
            self.close()
            raise

    def wall_ns(self, at_s: float) -> int:
        """Of a time of the program's clock, up to which the recording is now."""
        self.state.end_s = max(self.state.end_s, at_s)
        return round(at_s * NANOSECONDS) + self._offset_ns

    def add(self, topic: str, at_ns: int, data: bytes) -> None:
        """`at_ns`: from `wall_ns`."""
        Message(_CHANNELS[topic], at_ns, data, at_ns, 0).write(self._chunk)
        self._times_ns.append(at_ns)
        if self._chunk.count > FULL_CHUNK_BYTES:
            self._write_chunk()

    def note(self, at_s: float, event: str, **values: object) -> None:
        text = json.dumps({"event": event, **values}, ensure_ascii=False)
        self.add(EVENTS, self.wall_ns(at_s), text.encode(errors="replace"))  # a name may have bytes that are no text

    def flush(self, now_s: float, *, is_last: bool = False) -> None:
        """Writes everything that waits, and up to where the recording is whole."""
        self._write_chunk()
        if is_last:
            self._file.write(_records(DataEnd(0), Footer(0, 0, 0)) + MCAP0_MAGIC)
        self.state.end_s, self.state.is_ended = max(self.state.end_s, now_s), is_last
        # The state is written behind what it tells of: it never promises what is not in the file.
        self._file.seek(self._state_at)
        self._file.write(metadata_record(STATE, self.state))
        self._file.seek(0, os.SEEK_END)
        self._file.flush()

    def _write_chunk(self) -> None:
        if self._times_ns:
            records: bytes = self._chunk.end()  # type: ignore[no-untyped-call]
            self._unpacked_bytes += len(records)
            packed = zstandard.compress(records)
            first_ns, last_ns = min(self._times_ns), max(self._times_ns)
            self._file.write(_records(Chunk("zstd", packed, last_ns, first_ns, zlib.crc32(records), len(records))))
            self._times_ns = []

    def sync(self) -> None:
        """Waits until the data is safe from a power failure."""
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Never raises. Idempotent."""
        with suppress(OSError):  # what did not fit is lost
            self._file.close()

    def is_full(self, max_bytes: float) -> bool:
        """It is larger than that, or more would soon be more than is read of a file."""
        return self._file.tell() > max_bytes or self._unpacked_bytes > MAX_UNPACKED_BYTES // 2


# Reading


class SessionFile:
    """The messages of a recording. A file that is being written is read as far as it is written."""

    def __init__(self, path: Path) -> None:
        """Raises OSError, `UserError`."""
        self.path = path
        self.opening, self.state = read_head(path)
        # Of what was read so far.
        self.last_ns = self.opening.start_ns
        # There was more than could be read; known when all messages were.
        self.is_damaged = False

    @property
    def damage(self) -> UserMessage | None:
        """The sentence on what is missing in it; None for a whole recording."""
        if not self.is_damaged:
            return None
        at = datetime.fromtimestamp(self.last_ns / NANOSECONDS).astimezone()
        return message(marked("Damaged or altered; left out from {time} on."), time=f"{at:%H:%M:%S}")

    def messages(self) -> Iterator[tuple[str, int, bytes]]:
        """Goes through all messages up to the first damage: topic, nanoseconds since 1970, data. Raises OSError."""
        topics: dict[int, str] = {}
        reports = unpacked_bytes = 0
        try:
            with self.path.open("rb") as file:
                for record in StreamReader(file, emit_chunks=True, record_size_limit=MAX_CHUNK_BYTES).records:
                    if not isinstance(record, Chunk):
                        continue
                    # A few bytes may be packed gigabytes, whatever the record says.
                    size = max(record.uncompressed_size, zstandard.frame_content_size(record.data))
                    unpacked_bytes += size
                    if size > MAX_CHUNK_BYTES or unpacked_bytes > MAX_UNPACKED_BYTES:
                        raise ValueError("too large")
                    for part in breakup_chunk(record, validate_crc=True):
                        if isinstance(part, Channel):
                            topics[part.id] = part.topic
                        elif isinstance(part, Message):
                            topic = topics.get(part.channel_id, "")
                            self.last_ns = max(self.last_ns, part.log_time)
                            reports += topic == STATUS
                            yield topic, part.log_time, part.data
        except EndOfFile:
            self.is_damaged = self.state.is_ended  # else it was cut off, or is being written
        except _DAMAGES:
            self.is_damaged = True
        self.is_damaged |= reports < self.state.reports

    def traffic(self) -> Iterator[CaptureEntry]:
        """The bytes on the line in order; times count from the beginning of the recording. Raises OSError."""
        for topic, log_ns, data in self.messages():
            if topic in (RX, TX):
                at_s = (log_ns - self.opening.start_ns) / NANOSECONDS
                direction = Direction.MODULE_TO_HOST if topic == RX else Direction.HOST_TO_MODULE
                yield CaptureEntry(at_s, direction, data)
