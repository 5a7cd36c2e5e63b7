"""Reads session files chunk by chunk; what is damaged is passed over up to the next whole chunk."""

import mmap
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Final, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import Chunk, Metadata
from mcap.writer import MCAP0_MAGIC as MCAP_MAGIC

from app.recordings.session_format import CHANNELS, END, FORMAT, PROGRESS, Opening, is_whole, opening_of
from app.text.json_objects import object_in
from app.text.user_error import UserError
from protocol.translatable import marked

MAX_CHUNK_BYTES: Final = 1 << 26
MAX_UNPACKED_BYTES: Final = 1 << 31
"""Of a file: twice a day at full line rate."""
BLOCK_BYTES: Final = 1 << 24
"""A block ends when it holds this much."""
MAX_NS: Final = (1 << 63) - 1
"""Later times are not believed; numpy holds none."""
MAX_REPORTS_A_BYTE: Final = 1000
"""More are not believed: equal reports are packed to a hundredth."""
_HEAD: Final = struct.Struct("<BQ")
_MESSAGE: Final = struct.Struct("<BQHIQQ")
"""Head and fields of a message record, up to its data."""
_ZSTD: Final = b"\x04\x00\x00\x00zstd"
_ZSTD_AT: Final = _HEAD.size + 28
"""Where the name of the compression stands in a chunk: by it the next chunk is found."""
_MAX_HEADING: Final = 1 << 16
_NO_RECORD: Final = (McapError, ValueError, OverflowError, struct.error)
_SECTION: Final = frozenset(range(Opcode.HEADER, Opcode.DATA_END + 1))


class FileMessage(NamedTuple):
    topic: str
    log_ns: int
    data: bytes


@dataclass(slots=True)
class SessionFile:
    """One file, read once from its beginning. Times are nanoseconds since 1970."""

    opening: Opening
    """Of the first whole heading; `module` is that of the last one."""
    last_progress: bytes = b"{}"
    end_ns: int = 0
    is_ended: bool = False
    gaps: list[tuple[float, float]] = field(default_factory=list)
    """Monotonic times between which something is damaged or missing."""
    size_bytes: int = 0

    @property
    def reports(self) -> int:
        """Status reports up to `end_ns`, as counted when they were written."""
        reports = object_in(self.last_progress).get("reports")
        return reports if isinstance(reports, int) and 0 <= reports <= self.size_bytes * MAX_REPORTS_A_BYTE else 0

    @property
    def was_triggered(self) -> bool:
        return object_in(self.last_progress).get("triggered") is True

    def note_gap(self, until_ns: int) -> None:
        """Something after `end_ns` is damaged or missing."""
        self.gaps.append((self.opening.mono_s(self.end_ns), self.opening.mono_s(max(self.end_ns, until_ns))))


def read_blocks(path: Path, at_once: int = 1000) -> Iterator[tuple[SessionFile, list[FileMessage]]]:
    """Yields the messages of up to `at_once` chunks. A gap begins a new block. Raises OSError, `UserError`."""
    with _mapped(path) as data:
        yield from _Walk(data).blocks(at_once)


def read_heading(path: Path) -> SessionFile:
    """The heading and, without reading the file whole, where it ends. Raises OSError, `UserError`."""
    with _mapped(path) as data:
        return _Walk(data).heading()


@contextmanager
def _mapped(path: Path) -> Iterator[mmap.mmap]:
    with path.open("rb") as file:
        if file.read(len(MCAP_MAGIC)) != MCAP_MAGIC:
            raise UserError(marked("unknown kind of file"))
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
            yield data


class _Walk:
    def __init__(self, data: mmap.mmap) -> None:
        self._data, self._size = data, len(data)
        self._zstd = zstandard.ZstdDecompressor()
        self._file: SessionFile | None = None
        self._is_damaged = False
        self._chunks = self._unpacked_bytes = 0
        self._progress: FileMessage | None = None

    # Records

    def _records(self, place: int) -> Iterator[tuple[int, int, int]]:
        """Kind, begin and end of each record; nothing where it does not make sense, the caller looks further."""
        while place + _HEAD.size <= self._size:
            kind, length = _HEAD.unpack_from(self._data, place)
            end = place + _HEAD.size + length
            if kind not in _SECTION or end > self._size:
                return
            yield kind, place + _HEAD.size, end
            if kind == Opcode.DATA_END:
                return
            place = end

    def _next_chunk(self, place: int) -> int | None:
        while (frame_start := self._data.find(_ZSTD, place)) >= 0:
            start = frame_start - _ZSTD_AT
            if start >= place and self._data[start] == Opcode.CHUNK:
                _, length = _HEAD.unpack_from(self._data, start)
                if self._unpacked(start + _HEAD.size, start + _HEAD.size + length) is not None:
                    return start
            place = frame_start + 1
        return None

    def _unpacked(self, begin: int, end: int) -> bytes | None:
        """The records of a chunk; None where it is damaged."""
        if end > self._size:
            return None
        try:
            stream = ReadDataStream(BytesIO(self._data[begin:end]))
            chunk = Chunk.read(stream)
            packed, size = chunk.data, chunk.uncompressed_size
            total = self._unpacked_bytes + size
            if stream.count != end - begin or size > MAX_CHUNK_BYTES or total > MAX_UNPACKED_BYTES:
                return None
            self._unpacked_bytes = total
            if chunk.compression:
                if chunk.compression != "zstd" or zstandard.frame_content_size(packed) != size:
                    return None
                packed = self._zstd.decompress(packed)
        except (*_NO_RECORD, zstandard.ZstdError):
            return None
        return packed if len(packed) == size and zlib.crc32(packed) == chunk.uncompressed_crc else None

    # The whole file

    def blocks(self, at_once: int) -> Iterator[tuple[SessionFile, list[FileMessage]]]:
        messages: list[FileMessage] = []
        count = began = 0
        for chunk in self._chunk_messages():
            file = self._file
            if file is None:
                continue  # before the heading, there is none
            if self._is_damaged:
                if messages:
                    yield file, messages
                messages, count, self._is_damaged = [], 0, False
                file.note_gap(min(message.log_ns for message in chunk))
                yield file, []
            messages += chunk
            self._note_progress(file)
            count += 1
            if count >= at_once or self._unpacked_bytes - began >= BLOCK_BYTES:
                began = self._unpacked_bytes
                yield file, messages
                messages, count = [], 0
        if self._file is None:
            raise UserError(marked("not a recording by this program"))
        if self._is_damaged:
            self._file.note_gap(self._file.end_ns)
        yield self._file, messages

    def _note_progress(self, file: SessionFile) -> None:
        if self._progress is not None:
            file.end_ns, file.last_progress = max(file.end_ns, self._progress.log_ns), self._progress.data

    def _chunk_messages(self) -> Iterator[list[FileMessage]]:
        place: int | None = len(MCAP_MAGIC)
        while place is not None:
            for kind, begin, end in self._records(place):
                place = end
                if kind == Opcode.METADATA:
                    self._read_metadata(begin, end)
                elif kind == Opcode.DATA_END:
                    return
                elif kind == Opcode.CHUNK:
                    unpacked = self._unpacked(begin, end)
                    if unpacked is None:
                        self._is_damaged = True
                        place = begin  # its length may be what is damaged
                        break
                    messages = self._messages(unpacked)
                    if messages:
                        yield messages
            following = self._next_chunk(place)
            self._is_damaged |= following is not None
            place = following

    def _messages(self, chunk: bytes) -> list[FileMessage]:
        """Those in front of what is only for other viewers."""
        messages, place, size = [], 0, len(chunk)
        while place + _MESSAGE.size <= size:
            kind, length, channel, sequence, log_ns, _ = _MESSAGE.unpack_from(chunk, place)
            begin, place = place, place + _HEAD.size + length
            if kind == Opcode.MESSAGE:
                topic = CHANNELS.get(channel)
                if log_ns > MAX_NS:
                    self._is_damaged = True
                    continue
                if topic is not None:
                    messages.append(FileMessage(topic, log_ns, chunk[begin + _MESSAGE.size : place]))
                if topic == PROGRESS:
                    self._is_damaged |= sequence != self._chunks
                    self._chunks = sequence + 1
                    self._progress = messages[-1]
                    break
        return messages

    def _read_metadata(self, begin: int, end: int) -> None:
        if end - begin <= _MAX_HEADING:
            with suppress(*_NO_RECORD):
                self._on_metadata(Metadata.read(ReadDataStream(BytesIO(self._data[begin:end]))))

    def _on_metadata(self, record: Metadata) -> None:
        if record.name == FORMAT:
            if self._file is None:
                opening = opening_of(record.metadata)
                self._file = SessionFile(opening, end_ns=opening.wall_ns(opening.start_s), size_bytes=self._size)
            elif is_whole(record.metadata):
                self._file.opening = opening_of(record.metadata)
            else:
                self._is_damaged = True
        elif record.name == END and self._file is not None and is_whole(record.metadata):
            try:
                end_ns = int(record.metadata["end_ns"])
            except (KeyError, ValueError):
                return
            if not 0 <= end_ns <= MAX_NS:
                return
            self._file.end_ns = end_ns
            self._file.last_progress = record.metadata.get("progress", "{}").encode()
            self._file.is_ended = True

    # Heading and end only

    def heading(self) -> SessionFile:
        """Of a file that was closed by its index, else passing over the chunks and unpacking only the last one."""
        for record in self._indexed():
            self._on_metadata(record)
        if self._file is not None and self._file.is_ended:
            return self._file
        last: tuple[int, int] | None = None
        for kind, begin, end in self._records(len(MCAP_MAGIC)):
            if kind == Opcode.METADATA:
                self._read_metadata(begin, end)
            elif kind == Opcode.CHUNK:
                last = begin, end
        file = self._file
        if file is None:
            raise UserError(marked("not a recording by this program"))
        if not file.is_ended and last is not None:
            unpacked = self._unpacked(*last)
            if unpacked is not None:
                self._messages(unpacked)
                self._note_progress(file)
        return file

    def _indexed(self) -> list[Metadata]:
        """The metadata records by the summary at the end of the file; none without one."""
        reader = SeekingReader(self._data, record_size_limit=_MAX_HEADING)  # type: ignore[arg-type]
        with suppress(*_NO_RECORD, StopIteration):
            return list(reader.iter_metadata()) if reader.get_summary() is not None else []
        return []
