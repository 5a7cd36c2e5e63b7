"""Writes one file of a session, in the recorder's thread."""

import math
import os
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import IO, Final

from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import CompressionType, IndexType, Writer

from app.captures.entries import CaptureEntry, entries_of
from app.captures.explain import meaning
from app.captures.line import NANOSECONDS, LineBytes, LinePart
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
    PROGRESS,
    RX,
    SCHEMAS,
    STATUS,
    TX,
    Opening,
    json_bytes,
    with_checksum,
)
from app.system.files import lock, private_opener
from protocol.events import Event, Sent
from protocol.frame import Direction, Frame

STATUS_EVERY_NS: Final = NANOSECONDS // 10
"""Of the decoded reports for other viewers; a change of a flag is written in any case."""
EVERY_S: Final = 0.5
"""Of what was recorded before, as the recorder flushes."""
POLLED: Final = ("cell_voltage_v", "light_v")


Note = tuple[float, dict[str, object]]
"""An event: monotonic time and fields."""


class SessionWriter:
    """Methods raise OSError where the disk fails; what was flushed before stays readable."""

    def __init__(self, path: Path, opening: Opening) -> None:
        self.path = path
        self.opening = opening
        self.reports = 0
        self.was_triggered = False
        self.end_s = opening.start_s
        """Up to here everything is in the file."""
        self._limits = NO_LIMITS
        self._baud_rate = opening.baud_rate
        self._line: list[Event] = []
        self._entries: list[CaptureEntry] = []
        self._notes: list[Note] = []
        self._finder = ReportFinder()
        self._shown = 0, -1
        """Time and flags of the last report for other viewers."""
        # Values polled before the beginning are in the previous session.
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
            self._mcap.flush()  # type: ignore[no-untyped-call]
        except BaseException:
            self.close()
            raise

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

    def note(self, at: float, event: str, **values: object) -> None:
        self._notes.append((at, {"event": event, **values}))

    def name_module(self, module: str) -> None:
        self.opening = replace(self.opening, module=module)
        self._mcap.flush()  # type: ignore[no-untyped-call]
        self._mcap.add_metadata(FORMAT, self.opening.fields())
        self._mcap.flush()  # type: ignore[no-untyped-call]

    def flush(self, now_s: float, *, is_last: bool = False) -> None:
        """Writes everything pending as one chunk. Without anything, once a second that nothing came."""
        # Joins what was received together, also by several batches.
        self._entries += entries_of(self._line, 0.0)
        self._line = []
        is_idle = not (self._entries or self._notes)
        if is_idle and not is_last and now_s < self.end_s + 1.0:
            return
        line = LineBytes.of(self._entries, self.opening.wall_offset_ns, after_ns=self._line_ns)
        for topic, part in ((RX, line.received), (TX, line.sent)):
            for message in part.messages():
                self._add(topic, *message)
        self._line_ns = max(self._line_ns, line.end_ns)
        statuses = self._statuses(line.received)
        for at_s, event in self._notes:
            self._add(EVENTS, self.opening.wall_ns(at_s), json_bytes(event))
        noted_s = (at_s for at_s, _ in self._notes)
        self.end_s = max(self.end_s, now_s, self.opening.mono_s(self._line_ns), *noted_s)
        progress = json_bytes({"reports": self.reports, "triggered": self.was_triggered})
        end_ns = self.opening.wall_ns(self.end_s)
        self._add(PROGRESS, end_ns, progress, self._chunks)
        for status in statuses:  # our reader stops in front of them
            self._add(STATUS, *status)
        self._entries, self._notes = [], []
        self._chunks += 1
        self._mcap.flush()  # type: ignore[no-untyped-call]
        if is_last:
            end = {"progress": progress.decode(), "end_ns": str(end_ns)}
            self._mcap.add_metadata(END, with_checksum(end))
            self._mcap.finish()  # type: ignore[no-untyped-call]

    def _statuses(self, received: LinePart) -> list[tuple[int, bytes]]:
        """Counts the reports as our reader finds them; those for other viewers."""
        reports = self._finder.feed(received)
        self.reports += len(reports.flags)
        self.was_triggered |= bool((reports.flags & TRIGGERED).any())
        statuses = []
        columns = (reports.times_ns, reports.tilt_deg, reports.acceleration_g, reports.flags)
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
            self._file.flush()
            os.fsync(self._file.fileno())

    def close(self) -> None:
        """Closes the file; never raises. Idempotent."""
        file, self._file = self._file, None
        if file is not None:
            try:
                file.close()
            except OSError:
                return  # what did not fit is lost

    @property
    def size_bytes(self) -> int:
        return 0 if self._file is None else self._file.tell()

    @property
    def is_deleted(self) -> bool:
        """Whether somebody deleted the file: nobody will ever read what is written."""
        return self._file is not None and not os.fstat(self._file.fileno()).st_nlink and not self.path.exists()

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
