"""Writes the file of one recording, in the recorder's thread."""

import math
import os
from collections.abc import Iterable
from pathlib import Path
from typing import IO, Final

import msgspec
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import CompressionType, IndexType, Writer

from app.captures.entries import CaptureEntry, entries_of
from app.captures.explain import meaning
from app.captures.line import NANOSECONDS, LineBytes, LinePart
from app.engine.worker import Batch, PortState
from app.recordings.markers import NO_LIMITS, Marker, MarkerKind, limits_of
from app.recordings.reports import ACTIVE, TRIGGERED, ReportFinder
from app.recordings.session_format import (
    EVENTS,
    LINE_ENCODING,
    MAX_CHUNK_BYTES,
    OPENING,
    RX,
    SCHEMAS,
    STATE,
    STATUS,
    TX,
    Opening,
    State,
    json_bytes,
    metadata_record,
)
from app.system.files import lock, private_opener
from protocol.events import Event, Sent
from protocol.frame import Direction, Frame

STATUS_EVERY_NS: Final = NANOSECONDS // 10
"""Of the decoded reports for other viewers; a change of a flag is written in any case."""
POLLED: Final = ("cell_voltage_v", "light_v")


class SessionWriter:
    """Methods raise OSError where the disk fails; what was flushed before stays readable."""

    def __init__(self, path: Path, opening: Opening) -> None:
        self.path = path
        self.opening = opening
        self.state = State(end_s=opening.start_s)
        self._limits = NO_LIMITS
        self._baud_rate = opening.baud_rate
        self._line: list[Event] = []
        self._entries: list[CaptureEntry] = []
        self._notes: list[tuple[float, dict[str, object]]] = []
        self._finder = ReportFinder()
        # Time and flags of the last report for other viewers.
        self._shown = (0, -1)
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
        self._line += batch.events
        for event in batch.events:
            if isinstance(event, Sent) and not event.request.is_repeatable:
                self.note(event.at, "sent", **meaning(Frame(Direction.HOST_TO_MODULE, event.raw)))
        for marker in markers:
            self.note(marker.time_s, marker.kind.value, port=marker.text)
        rate = batch.connection.baud_rate
        if batch.connection.state is PortState.OPEN and rate != self._baud_rate:
            self._baud_rate = rate
            self.note(batch.at, "baud rate", baud_rate=rate)
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
        self._notes.append((at, {"event": event, **values}))

    def name_module(self, module: str, began_at: float) -> None:
        """`began_at`: when the conversation began in which the name was said."""
        at = max(began_at, self.opening.start_s)
        self.note(at, MarkerKind.NAMED.value, module=module)
        if module not in self.state.modules:
            self._advance(modules=(*self.state.modules, module))

    def flush(self, now_s: float, *, is_last: bool = False) -> None:
        """Writes everything pending as one chunk, and up to where the recording is whole."""
        # What was received together is joined, also from several batches.
        self._entries += entries_of(self._line, 0.0)
        self._line = []
        line = LineBytes.of(self._entries, self.opening.wall_offset_ns, after_ns=self._line_ns)
        for topic, part in ((RX, line.received), (TX, line.sent)):
            for log_ns, data in part.messages():
                self._add(topic, log_ns, data)
        for at_s, event in self._notes:
            self._add(EVENTS, self.opening.wall_ns(at_s), json_bytes(event))
        self._add_statuses(line.received)
        self._line_ns = max(self._line_ns, line.end_ns)
        has_chunk = len(line) > 0 or len(self._notes) > 0
        ends_s = [self.state.end_s, now_s, *(at_s for at_s, _ in self._notes)]
        if len(line):
            ends_s.append(self.opening.clock_s(line.end_ns))
        self._entries, self._notes = [], []
        if is_last:
            self._mcap.finish()  # type: ignore[no-untyped-call]
        else:
            self._mcap.flush()  # type: ignore[no-untyped-call]
        self._advance(end_s=max(ends_s), chunks=self.state.chunks + int(has_chunk), is_ended=is_last)
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

    def _add_statuses(self, received: LinePart) -> None:
        """Counts the reports as the reader finds them; writes those for other viewers."""
        reports = self._finder.feed(received)
        was_triggered = self.state.was_triggered or bool((reports.flags & TRIGGERED).any())
        self._advance(reports=self.state.reports + len(reports.flags), was_triggered=was_triggered)
        columns = (reports.times_ns, reports.tilt_deg, reports.acceleration_g, reports.flags)
        for at_ns, tilt, acceleration, flags in zip(*(column.tolist() for column in columns), strict=True):
            if at_ns < self._shown[0] + STATUS_EVERY_NS and flags == self._shown[1]:
                continue
            self._shown = (at_ns, flags)
            shown = {
                "tilt_deg": int(tilt),
                "acceleration_g": round(acceleration, 1),
                "triggered": bool(flags & TRIGGERED),
                "active": bool(flags & ACTIVE),
            }
            self._add(STATUS, at_ns, json_bytes(shown))

    def _add(self, topic: str, log_ns: int, data: bytes) -> None:
        self._mcap.add_message(self._channels[topic], log_ns, data, log_ns)

    def _register_channels(self) -> None:
        for topic in (RX, TX):
            self._channels[topic] = self._mcap.register_channel(topic, LINE_ENCODING, 0)
        for topic, fields in SCHEMAS.items():
            name = f"dps-s{topic.replace('/', '.')}"
            schema = json_bytes({"type": "object", "title": name, "properties": fields, "required": list(fields)})
            number = self._mcap.register_schema(name, SchemaEncoding.JSONSchema, schema)
            self._channels[topic] = self._mcap.register_channel(topic, MessageEncoding.JSON, number)
