"""Writes the file of one recording, in the recorder's thread."""

import json
import math
import os
from collections.abc import Iterable
from pathlib import Path
from typing import IO, Final

import msgspec
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import CompressionType, IndexType, Writer

from app.captures.traffic import Way, entries_of
from app.engine.worker import Batch
from app.recordings.markers import NO_LIMITS, Marker, MarkerKind, limits_of
from app.recordings.session_file import (
    EVENTS,
    MAX_CHUNK_BYTES,
    NANOSECONDS,
    OPENING,
    RX,
    STATE,
    STATUS,
    TX,
    Opening,
    RecordedReport,
    State,
    metadata_record,
)
from app.system.files import lock, private_opener

POLLED: Final = ("cell_voltage_v", "light_v")
_SCHEMAS: Final = {
    EVENTS: {"type": "object", "properties": {"event": {"type": "string"}}, "required": ["event"]},
    STATUS: msgspec.json.schema_components([RecordedReport])[1]["RecordedReport"],
}


class SessionWriter:
    """Methods raise OSError where the disk fails; what was flushed before stays readable."""

    def __init__(self, path: Path, opening: Opening) -> None:
        self.path = path
        self.opening = opening
        self.state = State(end_s=opening.start_s)
        self._end_s = opening.start_s
        self._offset_ns = opening.wall_offset_ns
        self._limits = NO_LIMITS
        # Values polled before the beginning are in the previous recording.
        self._polled_s = dict.fromkeys(POLLED, math.nextafter(opening.start_s, -math.inf))
        self._line_ns = 0
        self._channels: dict[str, int] = {}
        self._file: IO[bytes] = open(path, "xb", opener=private_opener)  # noqa: SIM115
        try:
            lock(self._file)
            self._mcap = Writer(
                self._file,
                chunk_size=MAX_CHUNK_BYTES,  # a chunk ends with `flush`
                compression=CompressionType.ZSTD,
                index_types=IndexType.NONE,
            )
            self._mcap.start(profile="", library="DPS-S Configurator")
            self._file.write(metadata_record(OPENING, opening))
            self._state_at = self._file.tell()
            self._file.write(metadata_record(STATE, self.state))
            self._register_channels()
        except BaseException:
            self.close()
            raise

    def put(self, batch: Batch, markers: Iterable[Marker]) -> None:
        """Takes in what the next `flush` writes."""
        for entry in entries_of(batch.events, 0.0):
            # Strictly ascending times tell the order of both directions.
            self._line_ns = max(self._line_ns + 1, self._ns(entry.at_s))
            self._add(RX if entry.way is Way.IN else TX, self._line_ns, entry.raw)
        for sample in batch.samples:
            report = RecordedReport(sample.tilt_deg, sample.acceleration_g, sample.triggered, sample.active)
            self._add(STATUS, self._ns(sample.at), msgspec.json.encode(report))
        has_triggered = any(sample.triggered for sample in batch.samples)
        self._advance(
            reports=self.state.reports + len(batch.samples),
            was_triggered=self.state.was_triggered or has_triggered,
        )
        for marker in markers:
            self.note(marker.time_s, marker.kind.value, port=marker.text)
        for key in POLLED:
            known = batch.conversation.values.get(key)
            if known is not None and known.at > self._polled_s[key]:
                self._polled_s[key] = known.at
                self.note(known.at, "reading", **{key: float(known.value)})
        limits = limits_of(batch.conversation, batch.at)
        if limits != self._limits:
            self._limits = limits
            self.note(batch.at, "limits", **limits._asdict())

    def note(self, at: float, event: str, **values: object) -> None:
        text = json.dumps({"event": event, **values}, ensure_ascii=False)
        self._add(EVENTS, self._ns(at), text.encode("utf-8", "backslashreplace"))

    def name_module(self, module: str, began_at: float) -> None:
        """`began_at`: when the conversation began in which the name was said."""
        self.note(max(began_at, self.opening.start_s), MarkerKind.NAMED.value, module=module)
        if module not in self.state.modules:
            self._advance(modules=(*self.state.modules, module))

    def flush(self, now_s: float, *, is_last: bool = False) -> None:
        """Writes everything pending as one chunk, and up to where the recording is whole."""
        if is_last:
            self._mcap.finish()  # type: ignore[no-untyped-call]
        else:
            self._mcap.flush()  # type: ignore[no-untyped-call]
        self._advance(end_s=max(self._end_s, now_s), is_ended=is_last)
        # The state is written behind what it tells of: it never promises what is not in the file.
        self._file.seek(self._state_at)
        self._file.write(metadata_record(STATE, self.state))
        self._file.seek(0, os.SEEK_END)
        self._file.flush()

    def sync(self) -> None:
        """Waits until the data is safe from a power failure."""
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Closes the file; never raises. Idempotent."""
        try:
            self._file.close()
        except OSError:
            return  # what did not fit is lost

    @property
    def size_bytes(self) -> int:
        return 0 if self._file.closed else self._file.tell()

    def _advance(self, **changes: object) -> None:
        self.state = msgspec.structs.replace(self.state, **changes)

    def _add(self, topic: str, log_ns: int, data: bytes) -> None:
        self._mcap.add_message(self._channels[topic], log_ns, data, log_ns)

    def _ns(self, at_s: float) -> int:
        self._end_s = max(self._end_s, at_s)
        return round(at_s * NANOSECONDS) + self._offset_ns

    def _register_channels(self) -> None:
        for topic in (RX, TX):
            self._channels[topic] = self._mcap.register_channel(topic, "bytes", 0)
        for topic, schema in _SCHEMAS.items():
            name = f"dps-s{topic.replace('/', '.')}"
            number = self._mcap.register_schema(name, SchemaEncoding.JSONSchema, msgspec.json.encode(schema))
            self._channels[topic] = self._mcap.register_channel(topic, MessageEncoding.JSON, number)
