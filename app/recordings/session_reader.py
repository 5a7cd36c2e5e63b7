"""Reads recordings chunk by chunk, up to the first damage."""

import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Final, NamedTuple

import zstandard
from mcap.exceptions import EndOfFile, McapError
from mcap.records import Channel, Chunk, McapRecord, Message, Metadata
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import MCAP0_MAGIC

from app.recordings.session_format import MAX_CHUNK_BYTES, OPENING, STATE, Opening, State, head_of
from app.text.user_error import UserError
from protocol.translatable import marked

HEAD_BYTES: Final = 8192
"""In these are the opening and the state."""
MAX_UNPACKED_BYTES: Final = 1 << 31
"""Of a file: twice a day at full line rate. Nothing is read beyond."""
MAX_NS: Final = (1 << 63) - 1
"""Later times are not believed; numpy holds none."""
_DAMAGES: Final = (McapError, zstandard.ZstdError, struct.error, ValueError, OverflowError, MemoryError)
"""What the libraries raise for damaged bytes."""


class FileMessage(NamedTuple):
    topic: str
    log_ns: int
    data: bytes


def read_head(path: Path) -> tuple[Opening, State]:
    """Where and when it was recorded, and how far. Raises OSError, `UserError`."""
    with path.open("rb", buffering=0) as file:
        head = file.read(HEAD_BYTES)
    if not head.startswith(MCAP0_MAGIC):
        raise UserError(marked("unknown kind of file"))
    opening: Opening | None = None
    try:
        for record in StreamReader(BytesIO(head), emit_chunks=True, record_size_limit=HEAD_BYTES).records:
            if isinstance(record, Metadata) and record.name == OPENING:
                opening = head_of(record, Opening)
            elif isinstance(record, Metadata) and record.name == STATE and opening is not None:
                return opening, head_of(record, State)
    except _DAMAGES:
        pass  # as is the state where a power failure came while it was written
    except UserError:
        if opening is None:
            raise
    if opening is None:
        raise UserError(marked("not a recording by this program"))
    return opening, State(end_s=opening.start_s)


class SessionFile:
    """The messages of a recording. A file that is being written is read as far as it is written."""

    def __init__(self, path: Path) -> None:
        """Raises OSError, `UserError`."""
        self.path = path
        self.opening, self.state = read_head(path)
        self.is_damaged = False
        """There was more than could be read; known when all chunks were read."""
        self._topics: dict[int, str] = {}
        self._chunks = 0

    def blocks(self, at_once: int = 1000) -> Iterator[list[FileMessage]]:
        """The messages of up to `at_once` chunks together. Raises OSError."""
        messages: list[FileMessage] = []
        try:
            for chunk in self._read_chunks():
                messages += self._messages_in(chunk)
                self._chunks += 1
                if self._chunks % at_once == 0:
                    yield messages
                    messages = []
        except _DAMAGES:
            self.is_damaged = True
        self.is_damaged |= self._chunks < self.state.chunks
        yield messages

    def _read_chunks(self) -> Iterator[list[McapRecord]]:
        unpacked_bytes = 0
        with self.path.open("rb") as file:
            records = StreamReader(file, emit_chunks=True, record_size_limit=MAX_CHUNK_BYTES).records
            while True:
                try:
                    record = next(records, None)
                except EndOfFile:
                    return  # it was cut off, or is being written
                if record is None:
                    return
                if isinstance(record, Chunk):
                    # A few bytes may be packed gigabytes.
                    size = record.uncompressed_size
                    unpacked_bytes += size
                    is_packed = record.compression != ""
                    if size > MAX_CHUNK_BYTES or unpacked_bytes > MAX_UNPACKED_BYTES:
                        raise ValueError("too large")
                    if is_packed and zstandard.frame_content_size(record.data) != size:
                        raise ValueError("not of the size that it says")
                    yield breakup_chunk(record, validate_crc=True)

    def _messages_in(self, chunk: list[McapRecord]) -> list[FileMessage]:
        messages: list[FileMessage] = []
        for record in chunk:
            if isinstance(record, Channel):
                self._topics[record.id] = record.topic
            elif isinstance(record, Message):
                if record.log_time > MAX_NS:
                    raise ValueError("a time that no clock shows")
                topic = self._topics.get(record.channel_id, "")
                messages.append(FileMessage(topic, record.log_time, record.data))
        return messages
