"""Records what goes over one port, in a background thread: from `begin` to `end` one file.

A conversation that ends is a mark in it, not its end. `on_batch` only adds a batch to a bounded list, so a slow, full
or missing disk never delays the link. What does not fit is counted and noted in the recording.
"""

import errno
import logging
import math
import shutil
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import msgspec

from app import version
from app.captures.traffic import Way, entries_of
from app.engine.conversation import ConversationView
from app.engine.worker import Batch
from app.recordings.library import RecordingLibrary, stopped_message
from app.recordings.markers import NO_LIMITS, Marker, MarkerKind, MarkerTracker, limits_of
from app.recordings.session_file import POLLED, RX, STATUS, TX, Opening, RecordedReport, SessionWriter
from app.system.clock import Clock, steady_time
from app.text.messages import UserMessage

_log = logging.getLogger(__name__)

FLUSH_EVERY_S = 0.5
# The disk is made to keep what was written, and is asked for its free space.
SYNC_EVERY_S = 30.0
# Left free for the store, which must be able to keep an intent.
RESERVE_BYTES = 256 * 1024**2
# Batches that wait for the thread; more than a minute of the fastest stream.
MAX_WAITING = 10_000
# After this, with a fifth of what the library may hold, or where it is full, it goes on in the next file.
MAX_SESSION_S = 24 * 3600.0


@dataclass(eq=False)
class _Port:
    """What is recorded, from `begin` to `end`."""

    name: str
    baud_rate: int
    begun_at: float


class Recorder:
    """Public methods may be called from any thread and return at once, except `stop` and `settle`.

    The thread starts with the first `begin`; a file is made with the first byte on the line.
    """

    def __init__(
        self,
        library: RecordingLibrary,
        *,
        clock: Clock = steady_time,
        wall_clock: Clock = time.time,
        find_free_bytes: Callable[[Path], int] = lambda folder: shutil.disk_usage(folder).free,
        max_waiting: int = MAX_WAITING,
    ) -> None:
        self.library = library
        # A recording was begun, although there may be no byte yet.
        self.is_recording = False
        # Status reports and events of this recording that were lost because the disk was too slow.
        self.dropped = 0
        self._clock = clock
        self._wall_clock = wall_clock
        self._find_free_bytes = find_free_bytes
        self._max_waiting = max_waiting
        self._acts: deque[Callable[[], None]] = deque()
        self._is_urgent = threading.Event()
        self._lock = threading.Lock()
        # Under the lock:
        self._thread: threading.Thread | None = None
        self._is_stopped = False
        self._begun: _Port | None = None
        self._error: Exception | None = None
        # Of the thread:
        self._port: _Port | None = None
        self._writer: SessionWriter | None = None
        self._tracker = MarkerTracker()
        # Before the first byte.
        self._markers: list[Marker] = []
        self._named: tuple[str, ConversationView] | None = None
        self._line_ns = 0
        # What the file tells of already.
        self._polled_s: dict[str, float] = {}
        self._limits = NO_LIMITS
        self._synced_at = 0.0
        self._noted = 0  # of `dropped`, those that the recording tells of

    # Any thread

    def begin(self, port: str, baud_rate: int) -> None:
        """Starts recording; ends the current recording."""
        with self._lock:
            if self._is_stopped:
                return
            self._begun = _Port(port, baud_rate, self._clock())
            self.is_recording, self._error = True, None
            self._put(self._end)
            self._put(partial(self._begin, self._begun))
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name="dps-s recorder", daemon=True)
                self._thread.start()

    def on_batch(self, batch: Batch) -> None:
        """Records this batch, if a recording was begun."""
        with self._lock:
            if not self.is_recording:
                return
            if len(self._acts) < self._max_waiting:
                self._acts.append(partial(self._record, batch))
            else:
                self.dropped += len(batch.samples) + len(batch.events)

    def name_module(self, module: str, conversation: ConversationView) -> None:
        """A person said which module it is in this conversation."""
        with self._lock:
            if self.is_recording:
                self._put(partial(self._name, module, conversation))

    def end(self) -> None:
        """Closes the recording. Idempotent."""
        with self._lock:
            if self.is_recording:
                self.is_recording = False
                self._put(self._end)

    def settle(self, deadline_s: float) -> bool:
        """Waits until everything before is on disk or given up; False on timeout."""
        done = threading.Event()
        with self._lock:
            if self._thread is None or self._is_stopped:
                return True
            self._put(self._maintain)
            self._put(done.set)
        return done.wait(deadline_s)

    def stop(self, deadline_s: float = 0.4) -> bool:
        """Closes the recording and ends the thread; False on timeout. Idempotent."""
        with self._lock:
            if not self._is_stopped:
                self.is_recording, self._is_stopped = False, True
                self._put(self._end)
        if self._thread is None:
            return True
        self._thread.join(deadline_s)
        return not self._thread.is_alive()

    @property
    def path(self) -> Path | None:
        """Of the current recording; None before the first byte."""
        writer = self._writer
        return None if writer is None else writer.path

    @property
    def opening(self) -> Opening | None:
        """Of the current recording; None before the first byte."""
        writer = self._writer
        return None if writer is None else writer.opening

    @property
    def trouble(self) -> UserMessage | None:
        """Why recording failed; the next `begin` tries again."""
        error = self._error
        return None if error is None else stopped_message(error, self.library.folder)

    def _put(self, act: Callable[[], None]) -> None:
        """To be done at once. Always fits."""
        self._acts.append(act)
        self._is_urgent.set()

    # The thread

    def _work(self) -> None:
        while self._acts or not self._is_stopped:
            self._is_urgent.wait(None if self._port is None else FLUSH_EVERY_S)
            self._is_urgent.clear()
            while self._acts:
                self._do(self._acts.popleft())
            self._do(self._maintain)

    def _do(self, act: Callable[[], None]) -> None:
        try:
            act()
        except Exception as error:  # noqa: BLE001  it ends the recording, and nothing else
            if not isinstance(error, OSError):
                _log.exception("The recorder met an error it did not expect")
            _log.warning("Not recorded any more: %s", error)
            failed, self._port = self._port, None
            self._release()
            with self._lock:
                if failed is self._begun:  # else another recording was begun since
                    self.is_recording, self._error = False, error

    def _begin(self, port: _Port) -> None:
        _log.debug("Recording %s", port.name)
        self._port = port
        self._tracker, self._markers, self._named = MarkerTracker(), [], None
        self.dropped = self._noted = 0

    def _record(self, batch: Batch) -> None:
        if self._port is None:
            return
        self._markers += self._tracker.on_batch(batch)
        if self._writer is None:
            firsts = [first.at for first in (*batch.samples[:1], *batch.events[:1])]
            if not firsts:
                return
            self._open(self._port, min(self._port.begun_at, *firsts))
            if self._named is not None and self._named[1].number == batch.conversation.number:
                self._name(*self._named)
        if self._writer is not None:
            self._write(self._writer, batch)

    def _write(self, writer: SessionWriter, batch: Batch) -> None:
        for entry in entries_of(batch.events, 0.0):
            # Strictly ascending times tell the order of both directions.
            self._line_ns = max(self._line_ns + 1, writer.wall_ns(entry.at_s))
            writer.add(RX if entry.way is Way.IN else TX, self._line_ns, entry.raw)
        for sample in batch.samples:
            report = RecordedReport(sample.tilt_deg, sample.acceleration_g, sample.triggered, sample.active)
            writer.add(STATUS, writer.wall_ns(sample.at), msgspec.json.encode(report))
        if batch.samples:
            was_triggered = writer.state.was_triggered or any(sample.triggered for sample in batch.samples)
            writer.advance(reports=writer.state.reports + len(batch.samples), was_triggered=was_triggered)
        for marker in self._markers:
            writer.note(marker.time_s, marker.kind.value, port=marker.text)
        self._markers = []
        for key in POLLED:
            known = batch.conversation.values.get(key)
            if known is not None and known.at > self._polled_s[key]:
                self._polled_s[key] = known.at
                writer.note(known.at, "reading", **{key: float(known.value)})
        limits = limits_of(batch.conversation, batch.at)
        if limits != self._limits:
            self._limits = limits
            writer.note(batch.at, "limits", **limits._asdict())

    def _name(self, module: str, conversation: ConversationView) -> None:
        self._named = (module, conversation)
        writer = self._writer
        if writer is not None:
            # A name holds from the beginning of its conversation on.
            writer.note(max(conversation.began_at, writer.opening.start_s), MarkerKind.NAMED.value, module=module)
            writer.advance(modules=tuple(dict.fromkeys((*writer.state.modules, module))))

    def _open(self, port: _Port, start_s: float) -> None:
        self.library.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        self.library.prune()
        self._check_disk()
        self._synced_at = self._clock()
        # Values polled before the beginning are in the previous recording.
        self._polled_s = dict.fromkeys(POLLED, math.nextafter(start_s, -math.inf))
        self._line_ns, self._limits = 0, NO_LIMITS
        opening = Opening(
            started_at=datetime.fromtimestamp(start_s + self._wall_clock() - self._clock(), UTC),
            start_s=start_s,
            port=port.name,
            baud_rate=port.baud_rate,
            program=f"DPS-S Configurator {version()}",
        )
        self._writer = SessionWriter(self.library.new_path(opening.started_at), opening)

    def _maintain(self) -> None:
        """Flushes, syncs, checks the disk, and goes on in the next file where this one is long enough."""
        writer, now = self._writer, self._clock()
        if writer is None or self._port is None:
            return
        self._flush(writer)
        if now - self._synced_at >= SYNC_EVERY_S:
            self._synced_at = now
            writer.sync()
            self._check_disk()
        is_large = writer.is_full or writer.size_bytes > self.library.max_bytes / 5
        if is_large or now - writer.opening.start_s > MAX_SESSION_S:
            port = self._port
            self._end()
            port.begun_at = now
            self._port = port

    def _check_disk(self) -> None:
        if self._find_free_bytes(self.library.folder) < RESERVE_BYTES:
            raise OSError(errno.ENOSPC, "the disk is nearly full")

    def _flush(self, writer: SessionWriter, *, is_last: bool = False) -> None:
        dropped = self.dropped
        if dropped > self._noted:
            writer.note(self._clock(), MarkerKind.MISSING.value, count=dropped - self._noted)
            self._noted = dropped
        writer.flush(self._clock(), is_last=is_last)

    def _end(self) -> None:
        if self._writer is not None:
            self._flush(self._writer, is_last=True)
            self._writer.sync()
        self._release()
        self._port = None

    def _release(self) -> None:
        """Closes the file, also one that failed."""
        if self._writer is not None:
            self._writer.close()
        self._writer = None
