"""Makes recordings for tests, from batches or from bytes; reads and explains them."""

import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import msgspec
import numpy as np

from app.captures.traffic import CaptureEntry, Explained, Explainer
from app.engine.conversation import ConversationView, How, Known, StatusSample
from app.engine.transport import PortError, PortErrorKind
from app.engine.worker import Batch, Connection, PortState
from app.recordings.library import RecordingLibrary, entry_of
from app.recordings.recorder import Recorder
from app.recordings.recording import Recording, open_recording
from app.recordings.session_file import RX, Opening, RecordedReport, SessionFile, SessionWriter
from app.recordings.session_file import STATUS as STATUS_TOPIC
from protocol.catalogue import STATUS
from protocol.events import Event, Received, Role, Sent
from protocol.fields import Value
from protocol.messages import Direction, Frame, Status
from tests.support.line.sim_line import FakeClock
from tests.support.patience import PATIENCE_S

NOON = datetime(2026, 11, 21, 12, 0, 0, tzinfo=UTC)
PORT = "/dev/ttyUSB0"
OPEN = Connection(PortState.OPEN, PORT, 115200)
CLOSED = OPEN._replace(state=PortState.CLOSED)
LOST = CLOSED._replace(trouble=PortError(PortErrorKind.LOST, PORT, ""))
LINE_HZ = 1440
NAME = "Bench 7"
TENTHS = 26
"""Count of values of acceleration that occur: 0.0 … 2.5 g."""


class Clock(FakeClock):
    """And the wall clock that goes with it."""

    wall_offset_s = NOON.timestamp() - 1000.0

    def wall(self) -> float:
        return self.now_s + self.wall_offset_s


def report(at: float, number: int = 0, *, triggered: bool = False, active: bool = False) -> StatusSample:
    """Return a status report; its values depend on `number`."""
    return StatusSample(at, number % 181, number % TENTHS / 10, triggered, active)


def received(sample: StatusSample) -> Received:
    """Return the event of the frame that carries a sample."""
    status = Status(sample.tilt_deg, sample.acceleration_g, sample.triggered, sample.active)
    frame = Frame(Direction.MODULE_TO_HOST, status.encode())
    return Received(frame, status, Role.STREAMED, sample.at)


def asked(at: float) -> Sent:
    request = STATUS.query()
    return Sent(request.encode(), request, 1, at)


def talk(at: float, *, number: int = 1, **values: Value) -> ConversationView:
    """Return a conversation that goes on, with values that were read at that time."""
    known = {key: Known(value, How.READ, at) for key, value in values.items()}
    return ConversationView(number=number, began_at=1000.0, values=MappingProxyType(known))


def batch(
    at: float,
    *samples: StatusSample,
    view: ConversationView | None = None,
    connection: Connection = OPEN,
    events: tuple[Event, ...] | None = None,
) -> Batch:
    """Make a batch; `events` are by default the frames of the samples."""
    frames = tuple(map(received, samples)) if events is None else events
    return Batch(at, connection, view or talk(at), None, samples, frames)


def stream(start_s: float, seconds: float, *, rate_hz: int = LINE_HZ) -> Iterator[Batch]:
    """Yield batches of 1/60 s of a stream, with cell voltage and light once a second."""
    count = round(seconds * rate_hz)
    times = start_s + np.arange(count) / rate_hz
    for numbers in np.array_split(np.arange(count), min(count, round(seconds * 60))):
        samples = tuple(report(float(times[n]), int(n)) for n in numbers)
        at = samples[-1].at
        polled_s = float(np.floor(at))
        volts, light = 3.0 + int(polled_s) % 100 / 100, int(polled_s) % 33 / 10
        view = talk(polled_s, cell_voltage_v=volts, light_v=light, attitude_threshold_deg=60)
        yield batch(at, *samples, view=view)


def settle(recorder: Recorder) -> None:
    """Waits until everything before is on disk or given up."""
    if not recorder.is_recording:
        assert recorder.stop(PATIENCE_S)
        return
    done = threading.Event()
    recorder._acts += (recorder._maintain, done.set)
    recorder._is_urgent.set()
    while recorder._thread.is_alive() and not done.wait(0.01):
        pass


@dataclass
class Bench:
    """Recorders on a fake clock, one after the other."""

    library: RecordingLibrary
    clock: Clock = field(default_factory=Clock)
    recorders: list[Recorder] = field(default_factory=list)

    @property
    def recorder(self) -> Recorder:
        return self.recorders[-1]

    def begin(self, port: str = PORT, baud_rate: int = 115200) -> None:
        """Ends the recording, if there is one, and begins the next."""
        if self.recorders:
            self.recorder.end()
        clocks = self.clock, self.clock.wall
        self.recorders.append(Recorder(self.library, port, baud_rate, *clocks))

    def feed(self, *batches: Batch) -> None:
        """Records batches, moves the clock to the last one and waits until they are on disk."""
        for one in batches:
            self.recorder.on_batch(one)
            self.clock.now_s = max(self.clock.now_s, one.at)
        self.settle()

    def record(self, *batches: Batch) -> None:
        """Begins a recording with these batches."""
        self.begin()
        self.feed(*batches)

    def name(self, module: str, *, number: int = 1) -> None:
        """A person says which module it is."""
        self.recorder.name_module(module, talk(self.clock.now_s, number=number))

    def finish(self) -> None:
        """Ends the recording."""
        assert self.recorder.stop(PATIENCE_S)

    def settle(self) -> None:
        settle(self.recorder)

    @property
    def path(self) -> Path:
        """Of the newest recording."""
        return self.library.entries()[0].path


@contextmanager
def recorder_in(folder: Path) -> Iterator[Bench]:
    bench = Bench(RecordingLibrary(folder))
    try:
        yield bench
    finally:
        for recorder in bench.recorders:
            assert recorder.stop(PATIENCE_S)


def recorded(folder: Path, seconds: float = 2.0, *, rate_hz: int = LINE_HZ) -> Path:
    """Record a session and close it; return its path."""
    with recorder_in(folder) as bench:
        bench.begin()
        bench.recorder.on_batch(batch(1000.0, events=(asked(1000.0),)))
        bench.feed(*stream(1000.0, seconds, rate_hz=rate_hz))
        bench.name(NAME)
        bench.finish()
        return bench.path


def write_session(
    path: Path, samples: Iterable[StatusSample], notes: Iterable[tuple[float, Mapping[str, Any]]] = (), *,
    started_at: datetime = NOON, start_s: float = 1000.0,
) -> None:  # fmt: skip
    """Write reports and events as a session that was closed properly, at once and without a recorder."""
    writer = SessionWriter(path, Opening(started_at=started_at, start_s=start_s, port=PORT, baud_rate=115200))
    for at_s, note in notes:
        writer.note(at_s, **note)
    for sample in samples:
        at_ns = writer.wall_ns(sample.at)
        kept = RecordedReport(sample.tilt_deg, sample.acceleration_g, sample.triggered, sample.active)
        writer.add(RX, at_ns, received(sample).frame.raw)
        writer.add(STATUS_TOPIC, at_ns, msgspec.json.encode(kept))
        writer.state.reports += 1
    writer.flush(sample.at, is_last=True)
    writer.close()


def opened(path: Path) -> Recording:
    """Raises `UserError`."""
    return open_recording(entry_of(path))


def directions(raw: list[tuple[Direction, bytes]]) -> dict[Direction, bytes]:
    """Join the bytes of each direction."""
    return {direction: b"".join(data for one, data in raw if one is direction) for direction in Direction}


class Whole(NamedTuple):
    """The content of a recording, for comparison."""

    path: Path
    times: list[float]
    tilts: list[float]
    raw: bytes


def whole_of(path: Path) -> Whole:
    recording = opened(path)
    window = recording.tilt.window(0.0, 1e9)
    raw = directions([(one.direction, one.raw) for one in SessionFile(recording.entry.path).traffic()])
    return Whole(path, window.time_s.tolist(), window.value.tolist(), raw[Direction.MODULE_TO_HOST])


def explained(entries: Iterable[CaptureEntry]) -> Iterator[Explained]:
    explainer = Explainer()
    for entry in entries:
        yield from explainer.feed(entry)
    yield from explainer.end()
