"""Writes one file of a session, in the recorder's thread."""

import math
import os
from collections import deque
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import IO, Final, NamedTuple

from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import CompressionType, IndexType, Writer

from app.captures.entries import CaptureEntry, Way, entries_of
from app.captures.explain import meaning
from app.engine.device import DeviceView
from app.engine.worker import Batch, PortState
from app.recordings.markers import NO_LIMITS, Marker, ModuleLimits
from app.recordings.reports import ACTIVE, TRIGGERED, ReportFinder
from app.recordings.session_format import (
    CHANNELS,
    END,
    EVENTS,
    FORMAT,
    LINE_ENCODING,
    NANOSECONDS,
    PROGRESS,
    SCHEMAS,
    STATUS,
    TOPIC_OF_WAY,
    Opening,
    json_bytes,
    line_messages,
    line_part,
    with_checksum,
)
from app.system.files import draft_of, lock, private_opener
from protocol.events import Event, Sent
from protocol.frame import Direction, Frame

STATUS_EVERY_NS: Final = NANOSECONDS // 10
"""Of the decoded reports for other viewers; a change of a flag is written in any case."""
POLLED: Final = ("cell_voltage_v", "light_v")


class Note(NamedTuple):
    """An event of a session that was recorded before."""

    at_s: float
    event: str
    values: dict[str, object]


class SessionWriter:
    """Methods raise OSError where the disk fails; what was flushed before stays readable."""

    def __init__(self, path: Path, opening: Opening) -> None:
        self.path = path
        self.opening = opening
        self.reports = self.size_bytes = 0
        self.was_triggered = False
        self.end_s = opening.start_s
        """Up to here everything is in the file."""
        self._offset_ns = opening.wall_offset_ns
        self._limits = NO_LIMITS
        self._baud_rate = opening.baud_rate
        self._line: list[Event] = []
        self._entries: list[CaptureEntry] = []
        self._events: list[tuple[float, dict[str, object]]] = []
        self._finder = ReportFinder()
        self._shown = 0, -1
        """Time and flags of the last report for other viewers."""
        # Values polled before the beginning are in the previous part.
        self._polled_s = dict.fromkeys(POLLED, math.nextafter(opening.start_s, -math.inf))
        self._line_ns = 0
        self._chunks = 0
        self._numbers = {topic: number for number, topic in CHANNELS.items()}
        self._file: IO[bytes] | None = open(path, "xb", opener=private_opener)  # noqa: SIM115
        try:
            lock(self._file)
            self._mcap = Writer(self._file, compression=CompressionType.ZSTD, index_types=IndexType.METADATA)
            self._mcap.start(profile="", library="DPS-S Configurator")
            self._mcap.add_metadata(FORMAT, opening.fields())
            self._register()
            self._flush()
        except BaseException:
            self.close()
            raise

    def begin_with(self, limits: ModuleLimits) -> None:
        """A further part says what is in force at its beginning."""
        if limits != self._limits:
            self._limits = limits
            self.note(self.opening.start_s, "limits", **limits._asdict())

    def put(self, batch: Batch, markers: Iterable[Marker], limits: ModuleLimits) -> None:
        """Takes in what the next `flush` writes."""
        self._line += batch.events
        for event in batch.events:
            if isinstance(event, Sent) and not event.request.is_repeatable:
                self.note(event.at, "sent", **meaning(Frame(Direction.HOST_TO_MODULE, event.raw)))
        if batch.connection.state is PortState.OPEN:
            # While a port opens, the view is still that of the previous module.
            self._put_polled(batch.device)
            if batch.connection.baud_rate != self._baud_rate:
                self._baud_rate = batch.connection.baud_rate
                self.note(batch.at, "baud rate", baud_rate=self._baud_rate)
        for marker in markers:
            self.note(marker.time_s, marker.kind.value, port=marker.port)
        if limits != self._limits:
            self._limits = limits
            self.note(batch.at, "limits", **limits._asdict())

    def put_recorded(self, entries: Iterable[CaptureEntry], notes: Iterable[Note], *, every_s: float = 0.5) -> float:
        """Takes in and flushes what was recorded before, without a module; returns the time of the last of it."""
        left, end_s = deque(notes), self.opening.start_s
        flushed_s = end_s
        for entry in entries:
            while left and left[0].at_s <= entry.at_s:
                self._put_note(left.popleft())
            if entry.at_s > flushed_s + every_s:
                self.flush(end_s)
                flushed_s = entry.at_s
            self._entries.append(entry)
            end_s = max(end_s, entry.at_s)
        for note in left:
            self._put_note(note)
            end_s = max(end_s, note.at_s)
        return end_s

    def _put_note(self, note: Note) -> None:
        self.note(note.at_s, note.event, **note.values)

    def note(self, at: float, event: str, **values: object) -> None:
        self._events.append((at, {"event": event, **values}))

    def name_module(self, module: str) -> None:
        self.opening = replace(self.opening, module=module)
        self._flush()
        self._mcap.add_metadata(FORMAT, self.opening.fields())
        self._flush()

    def flush(self, now_s: float, *, is_last: bool = False) -> None:
        """Writes everything pending as one chunk. Without anything, once a second that nothing came."""
        # Joins what was received together, also by several batches.
        self._entries += entries_of(self._line, 0.0)
        self._line = []
        is_idle = not (self._entries or self._events)
        if is_idle and not is_last and now_s < self.end_s + 1.0:
            return
        ordered = self._ordered()
        statuses: list[tuple[int, bytes]] = []
        for way, topic in TOPIC_OF_WAY.items():
            messages = list(line_messages((at, entry.raw) for at, entry in ordered if entry.way is way))
            for message in messages:
                self._add(topic, *message)
            if way is Way.IN:
                statuses = self._statuses(messages)
        if ordered:
            self._line_ns = ordered[-1][0]
            self.end_s = max(self.end_s, (self._line_ns - self._offset_ns) / NANOSECONDS)
        self._entries = []
        for at_s, event in self._events:
            self.end_s = max(self.end_s, at_s)
            self._add(EVENTS, self._wall_ns(at_s), json_bytes(event))
        self.end_s = max(self.end_s, now_s)
        progress = json_bytes({"reports": self.reports, "triggered": self.was_triggered})
        self._add(PROGRESS, self._wall_ns(self.end_s), progress, self._chunks)
        for status in statuses:  # our reader stops in front of them
            self._add(STATUS, *status)
        self._events = []
        self._chunks += 1
        self._flush()
        if is_last:
            end = {"progress": progress.decode(), "end_ns": str(self._wall_ns(self.end_s))}
            self._mcap.add_metadata(END, with_checksum(end))
            self._mcap.finish()  # type: ignore[no-untyped-call]
            self._sync()

    def _statuses(self, received: list[tuple[int, bytes]]) -> list[tuple[int, bytes]]:
        """Counts the reports as our reader finds them; those for other viewers."""
        found = self._finder.feed(line_part(received))
        self.reports += len(found.flags)
        self.was_triggered |= bool((found.flags & TRIGGERED).any())
        statuses = []
        columns = (found.times_ns, found.tilt_deg, found.acceleration_g, found.flags)
        for at_ns, tilt, acceleration, flags in zip(*(column.tolist() for column in columns), strict=True):
            if at_ns >= self._shown[0] + STATUS_EVERY_NS or flags != self._shown[1]:
                self._shown = at_ns, flags
                fields = {"tilt_deg": int(tilt), "acceleration_g": round(acceleration, 1),
                          "triggered": bool(flags & TRIGGERED), "active": bool(flags & ACTIVE)}  # fmt: skip
                statuses.append((at_ns, json_bytes(fields)))
        return statuses

    def sync(self) -> None:
        """Waits until the data is safe from a power failure."""
        if self._file is not None:
            self._sync()

    def close(self) -> None:
        """Closes the file; never raises. Idempotent."""
        file, self._file = self._file, None
        if file is not None:
            try:
                file.close()
            except OSError:
                return  # what did not fit is lost

    def _flush(self) -> None:
        self._mcap.flush()  # type: ignore[no-untyped-call]
        if self._file is not None:
            self.size_bytes = self._file.tell()

    def _sync(self) -> None:
        if self._file is not None:
            self._file.flush()
            os.fsync(self._file.fileno())

    def _ordered(self) -> list[tuple[int, CaptureEntry]]:
        """With times that increase by at least 1 ns, so that the order of both directions is kept."""
        ordered, last = [], self._line_ns
        for entry in self._entries:
            last = max(last + 1, self._wall_ns(entry.at_s))
            ordered.append((last, entry))
        return ordered

    def _wall_ns(self, at_s: float) -> int:
        return round(at_s * NANOSECONDS) + self._offset_ns

    def _add(self, topic: str, log_ns: int, data: bytes, sequence: int = 0) -> None:
        self._mcap.add_message(self._numbers[topic], log_ns, data, log_ns, sequence)

    def _register(self) -> None:
        for topic in CHANNELS.values():
            fields, schema, encoding = SCHEMAS.get(topic), 0, LINE_ENCODING
            if fields is not None:
                name = f"dps-s{topic.replace('/', '.')}"
                whole = {"type": "object", "title": name, "properties": fields, "required": list(fields)}
                schema = self._mcap.register_schema(name, SchemaEncoding.JSONSchema, json_bytes(whole))
                encoding = MessageEncoding.JSON
            self._mcap.register_channel(topic, encoding, schema)

    def _put_polled(self, device: DeviceView) -> None:
        for key in POLLED:
            known = device.values.get(key)
            if known is not None and not known.is_stale and known.at > self._polled_s[key]:
                self._polled_s[key] = known.at
                self.note(known.at, "reading", **{key: float(known.value)})


def write_session(
    path: Path,
    opening: Opening,
    entries: Iterable[CaptureEntry],
    notes: Iterable[Note] = (),
    *,
    end_s: float = -math.inf,
    is_ended: bool = True,
    is_private: bool = False,
) -> None:
    """Writes a session from bytes on the line and events, both in order of time (monotonic). Raises OSError.

    `end_s`: up to when it was recorded, if later than the last of them; `is_ended`: it was closed properly.
    """
    with draft_of(path, is_private=is_private) as draft:
        draft.unlink()
        writer = SessionWriter(draft, opening)
        try:
            end_s = max(end_s, writer.put_recorded(entries, notes))
            writer.flush(end_s)
            if is_ended:
                writer.flush(end_s, is_last=True)
            writer.sync()
        finally:
            writer.close()
