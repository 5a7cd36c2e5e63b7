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
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import msgspec

from app import version
from app.captures.traffic import Way, entries_of
from app.engine.conversation import ConversationView
from app.engine.worker import Batch
from app.recordings.library import RecordingLibrary
from app.recordings.markers import NO_LIMITS, Marker, MarkerKind, MarkerTracker, limits_of
from app.recordings.session_file import POLLED, RX, STATUS, TX, Opening, RecordedReport, SessionWriter
from app.system.clock import Clock, steady_time
from app.text.messages import UserMessage, error_text, message
from protocol.translatable import marked

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
_DISK_FULL = frozenset({errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)})


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
        self.clock, self.wall_clock, self.find_free_bytes = clock, wall_clock, find_free_bytes
        self._max_waiting = max_waiting
        self._acts: deque[Callable[[], None]] = deque()
        self._is_urgent = threading.Event()
        # One that may be taken again: what begins or stops also ends.
        self._lock = threading.RLock()
        # Under the lock:
        self._thread: threading.Thread | None = None
        self._is_stopped = False
        # The present recording, or the last one.
        self._session: _Session | None = None

    def begin(self, port: str, baud_rate: int) -> None:
        """Starts recording; ends the current recording."""
        with self._lock:
            if self._is_stopped:
                return
            self.end()
            self._session = _Session(self, port, baud_rate)
            self._is_urgent.set()
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name="dps-s recorder", daemon=True)
                self._thread.start()

    def on_batch(self, batch: Batch) -> None:
        """Records this batch, if a recording was begun."""
        with self._lock:
            session = self._session
            if session is None or not session.is_open:
                return
            if len(self._acts) < self._max_waiting:
                self._acts.append(partial(session.do, session.record, batch))
            else:
                session.dropped += len(batch.samples) + len(batch.events)

    def name_module(self, module: str, conversation: ConversationView) -> None:
        """A person said which module it is in this conversation."""
        with self._lock:
            if self._session is not None and self._session.is_open:
                self._put(partial(self._session.do, self._session.name, module, conversation))

    def end(self) -> None:
        """Closes the recording. Idempotent."""
        with self._lock:
            if self._session is not None and self._session.is_open:
                self._session.is_open = False
                self._put(partial(self._session.do, self._session.close))

    def settle(self, deadline_s: float) -> bool:
        """Waits until everything before is on disk or given up; False on timeout."""
        done = threading.Event()
        with self._lock:
            if self._session is None or self._is_stopped:
                return True
            self._put(partial(self._session.do, self._session.maintain))
            self._put(done.set)
        return done.wait(deadline_s)

    def stop(self, deadline_s: float = 0.4) -> bool:
        """Closes the recording and ends the thread; False on timeout. Idempotent."""
        with self._lock:
            self.end()
            self._is_stopped = True
            self._is_urgent.set()
        if self._thread is None:
            return True
        self._thread.join(deadline_s)
        return not self._thread.is_alive()

    @property
    def is_recording(self) -> bool:
        """A recording was begun, although there may be no byte yet."""
        return self._session is not None and self._session.is_open

    @property
    def dropped(self) -> int:
        """Status reports and events of this recording that were lost because the disk was too slow."""
        return 0 if self._session is None else self._session.dropped

    @property
    def path(self) -> Path | None:
        """Of the current recording; None before the first byte."""
        writer = None if self._session is None else self._session.writer
        return None if writer is None else writer.path

    @property
    def started_at(self) -> datetime | None:
        """Of the current recording; None before the first byte."""
        writer = None if self._session is None else self._session.writer
        return None if writer is None else writer.opening.started_at

    @property
    def trouble(self) -> UserMessage | None:
        """Why recording failed; the next `begin` tries again."""
        error = None if self._session is None else self._session.error
        if error is None:
            return None
        if isinstance(error, OSError) and error.errno in _DISK_FULL:
            return message(marked("Not recording: the disk is full. Free some space, then connect again."))
        return message(marked("Not recording to {folder}: {why}."), folder=self.library.folder, why=error_text(error))

    def _put(self, act: Callable[[], None]) -> None:
        """To be done at once. Always fits."""
        self._acts.append(act)
        self._is_urgent.set()

    def _work(self) -> None:
        while self._acts or not self._is_stopped:
            self._is_urgent.wait(FLUSH_EVERY_S if self.is_recording else None)
            self._is_urgent.clear()
            while self._acts:
                self._acts.popleft()()
            session = self._session
            if session is not None:
                session.do(session.maintain)


class _Session:
    """One recording. Its methods belong to the recorder's thread."""

    def __init__(self, recorder: Recorder, port: str, baud_rate: int) -> None:
        self._recorder, self._port, self._baud_rate = recorder, port, baud_rate
        self._begun_at = recorder.clock()
        # Of any thread, under the recorder's lock.
        self.is_open = True
        self.dropped = 0
        self.error: Exception | None = None
        # None before the first byte.
        self.writer: SessionWriter | None = None
        self._tracker = MarkerTracker()
        # What the file does not tell of yet, and what it does.
        self._markers: list[Marker] = []
        self._named: tuple[str, ConversationView] | None = None
        self._noted = 0  # of `dropped`
        self._polled_s: dict[str, float] = {}
        self._limits = NO_LIMITS
        self._line_ns = 0
        self._synced_at = 0.0

    def do(self, act: Callable[..., None], *args: object) -> None:
        if self.error is not None:
            return
        try:
            act(*args)
        except Exception as error:  # noqa: BLE001  it ends the recording, and nothing else
            if not isinstance(error, OSError):
                _log.exception("The recorder met an error it did not expect")
            _log.warning("Not recorded any more: %s", error)
            if self.writer is not None:
                self.writer.close()
            self.writer = None
            self.is_open, self.error = False, error

    def record(self, batch: Batch) -> None:
        self._markers += self._tracker.on_batch(batch)
        writer = self.writer
        if writer is None:
            firsts = [first.at for first in (*batch.samples[:1], *batch.events[:1])]
            if not firsts:
                return
            writer = self.writer = self._open(min(self._begun_at, *firsts))
            if self._named is not None and self._named[1].number == batch.conversation.number:
                self.name(*self._named)
        for entry in entries_of(batch.events, 0.0):
            # Strictly ascending times tell the order of both directions.
            self._line_ns = max(self._line_ns + 1, writer.wall_ns(entry.at_s))
            writer.add(RX if entry.way is Way.IN else TX, self._line_ns, entry.raw)
        for sample in batch.samples:
            report = RecordedReport(sample.tilt_deg, sample.acceleration_g, sample.triggered, sample.active)
            writer.add(STATUS, writer.wall_ns(sample.at), msgspec.json.encode(report))
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

    def name(self, module: str, conversation: ConversationView) -> None:
        self._named = (module, conversation)
        writer = self.writer
        if writer is not None:
            # A name holds from the beginning of its conversation on.
            writer.note(max(conversation.began_at, writer.opening.start_s), MarkerKind.NAMED.value, module=module)
            writer.advance(modules=tuple(dict.fromkeys((*writer.state.modules, module))))

    def _open(self, start_s: float) -> SessionWriter:
        library, clock = self._recorder.library, self._recorder.clock
        library.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        library.prune()
        self._check_disk()
        self._synced_at = clock()
        # Values polled before the beginning are in the previous recording.
        self._polled_s = dict.fromkeys(POLLED, math.nextafter(start_s, -math.inf))
        self._line_ns, self._limits = 0, NO_LIMITS
        opening = Opening(
            started_at=datetime.fromtimestamp(start_s + self._recorder.wall_clock() - clock(), UTC),
            start_s=start_s,
            port=self._port,
            baud_rate=self._baud_rate,
            program=f"DPS-S Configurator {version()}",
        )
        _log.debug("Recording %s", self._port)
        return SessionWriter(library.new_path(opening.started_at), opening)

    def maintain(self) -> None:
        """Flushes, syncs, checks the disk, and goes on in the next file where this one is long enough."""
        writer, now = self.writer, self._recorder.clock()
        if writer is None:
            return
        self._flush(writer)
        if now - self._synced_at >= SYNC_EVERY_S:
            self._synced_at = now
            writer.sync()
            self._check_disk()
        is_large = writer.is_full or writer.size_bytes > self._recorder.library.max_bytes / 5
        if is_large or now - writer.opening.start_s > MAX_SESSION_S:
            self.close()
            self._begun_at = now

    def _check_disk(self) -> None:
        if self._recorder.find_free_bytes(self._recorder.library.folder) < RESERVE_BYTES:
            raise OSError(errno.ENOSPC, "the disk is nearly full")

    def _flush(self, writer: SessionWriter, *, is_last: bool = False) -> None:
        dropped = self.dropped
        if dropped > self._noted:
            writer.note(self._recorder.clock(), MarkerKind.MISSING.value, count=dropped - self._noted)
            self._noted = dropped
        writer.flush(self._recorder.clock(), is_last=is_last)

    def close(self) -> None:
        if self.writer is not None:
            self._flush(self.writer, is_last=True)
            self.writer.sync()
            self.writer.close()
            self.writer = None
