"""Opens a recording for reading, and exports it for other programs."""

from array import array
from collections.abc import Callable, Iterable
from contextlib import suppress
from itertools import chain
from operator import itemgetter
from pathlib import Path

import msgspec
import numpy as np

from app.recordings.excerpt import ACTIVE, TRIGGERED, Measured, csv_parts, part_count
from app.recordings.library import RecordingEntry, unreadable
from app.recordings.markers import Marker, MarkerKind, ModuleLimits
from app.recordings.session_file import EVENTS, NANOSECONDS, POLLED, STATUS, RecordedEvent, RecordedReport, SessionFile
from app.samples.samples import Readable
from app.system.files import whole_file
from app.text.messages import UserError, UserMessage

_MARKS = {kind.value: kind for kind in MarkerKind}


class Recording(Measured):
    """Made by `open_recording`. Immutable; a running recording is read as far as it is written.

    Times are seconds of the recording computer's clock; add `wall_offset_s` for seconds since 1970.
    """

    def __init__(self, entry: RecordingEntry) -> None:
        """Raises OSError, `UserError`."""
        super().__init__()
        self.entry = entry
        file = SessionFile(entry.path)
        self.opening = opening = file.opening
        self.wall_offset_s = opening.wall_offset_ns / NANOSECONDS
        # A day has millions of reports.
        times_s, tilt, acceleration, flags = array("d"), array("f"), array("f"), array("f")
        events: list[tuple[float, RecordedEvent]] = []
        report_of = msgspec.json.Decoder(RecordedReport).decode
        event_of = msgspec.json.Decoder(RecordedEvent).decode
        for topic, log_ns, data in file.messages():
            at_s = opening.clock_s(log_ns)
            with suppress(ValueError, RecursionError):  # of another program
                if topic == STATUS:
                    report = report_of(data)
                    times_s.append(at_s)
                    tilt.append(report.tilt_deg)
                    acceleration.append(report.acceleration_g)
                    flags.append(report.active * ACTIVE | report.triggered * TRIGGERED)
                elif topic == EVENTS:
                    events.append((at_s, event_of(data)))
        # Readers rely on ascending times.
        events.sort(key=itemgetter(0))
        ascending_s = np.maximum.accumulate(np.frombuffer(times_s))
        self.tilt, self.acceleration, self.flags = (
            Readable(ascending_s, np.frombuffer(values, np.float32)) for values in (tilt, acceleration, flags)
        )

        def polled(key: str) -> Readable:
            readings = ((at_s, getattr(event, key)) for at_s, event in events if event.event == "reading")
            known = [(at_s, value) for at_s, value in readings if value is not None]
            times, values = np.array(known, np.float64).reshape(-1, 2).T
            return Readable(times, values.astype(np.float32))

        self.cell, self.light, self.charging = map(polled, POLLED)
        marks: list[Marker] = []
        for at_s, event in events:
            if event.event == "limits":
                self.put(at_s, ModuleLimits(*(getattr(event, name) for name in ModuleLimits._fields)))
            elif event.event in _MARKS:
                marks.append(Marker(at_s, _MARKS[event.event], event.module or event.port))
        self.damage = file.damage
        last_s = opening.clock_s(file.last_ns)
        self.end_s = max(last_s, file.state.end_s)
        if file.is_damaged:
            marks.append(Marker(last_s, MarkerKind.DAMAGED))
        self.markers = marks
        self.start_s = min((opening.start_s, *(marker.time_s for marker in marks[:1])))


def open_recording(entry: RecordingEntry) -> Recording:
    """Opens a recording and verifies all checksums. Takes seconds for a long one: not for the window's thread. Raises
    `UserError`."""
    try:
        return Recording(entry)
    except (OSError, UserError) as error:
        raise UserError(unreadable(entry.path, error)) from error


# Export

# Gets 0 … 1 in the calling thread. What it raises ends the export, and the file is unchanged.
Progress = Callable[[float], object]
_BLOCK_BYTES = 1 << 20


def write_parts(path: Path, parts: Iterable[bytes], count: int, on_progress: Progress = bool) -> None:
    """Writes a file atomically. `count`: about how many parts. Raises OSError, and what `on_progress` raises."""
    with whole_file(path) as file:
        for number, part in enumerate(parts):
            on_progress(min(1.0, number / count))
            file.write(part)
        on_progress(1.0)


def export(
    entry: RecordingEntry, path: Path, *, appends: bool = False, on_progress: Progress = bool
) -> tuple[int, UserMessage | None]:
    """Copies the session into a file of its kind, else writes a CSV table, with `appends` behind the rows of the file.
    Returns the rows, and what is missing, because it is damaged in the recording. Raises OSError, `UserError`, and what
    `on_progress` raises."""
    recording = open_recording(entry)
    if path.suffix.lower() == entry.path.suffix:
        with entry.path.open("rb") as file:
            blocks = iter(lambda: file.read(_BLOCK_BYTES), b"")
            write_parts(path, blocks, entry.size_bytes // _BLOCK_BYTES + 1, on_progress)
        return len(recording.tilt), recording.damage
    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    rows = csv_parts(excerpt, wall_offset_s=recording.wall_offset_s)
    if appends and path.exists() and path.stat().st_size:
        next(rows)  # without a second head
        before = path.read_bytes()
        rows = chain((before, b"" if before.endswith(b"\n") else b"\r\n"), rows)
    write_parts(path, rows, part_count(excerpt), on_progress)
    return excerpt.row_count, recording.damage
