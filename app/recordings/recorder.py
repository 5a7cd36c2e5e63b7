"""Records the current session in a background thread.

`on_batch` only adds a batch to a bounded list, so a slow, full or missing disk never delays the link. What does not fit
is counted and noted in the recording.
"""

import errno
import logging
import shutil
import threading
import time
from collections.abc import Callable
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import NamedTuple

from app import version
from app.captures.line import NANOSECONDS
from app.engine.device import Sleep
from app.engine.worker import Batch
from app.recordings.library import RecordingLibrary, new_path, stopped_message
from app.recordings.markers import Marker, MarkerKind, MarkerTracker
from app.recordings.session_format import Opening
from app.recordings.writer import SessionWriter
from app.stations.station import find_station, fingerprint_of
from app.text.messages import UserMessage
from app.text.user_error import UserError

_log = logging.getLogger(__name__)

FLUSH_EVERY_S = 0.5
SYNC_EVERY_S = 30.0
DISK_CHECK_EVERY_S = 10.0
RESERVE_BYTES = 256 * 1024**2
MAX_WAITING = 200_000
"""Status reports and events that wait for the thread; more than a minute at full line rate."""
MAX_SESSION_S = 24 * 3600.0
CLOCK_JUMP_S = 2.0
"""Change of the wall clock after which a new session begins, with the right time."""


class _Session(NamedTuple):
    """What is known when a session begins. `number` counts the sessions, to tell a failure of this one from one of an
    earlier session."""

    port: str
    baud_rate: int
    module: str
    at: float
    number: int


class Recorder:
    """Public methods may be called from any thread and return at once, except `stop` and `settle`.

    The thread starts with the first `begin`; a file is made with the first byte on the line.
    """

    def __init__(
        self,
        library: RecordingLibrary,
        *,
        clock: Callable[[], float] = time.monotonic,
        wall_clock: Callable[[], float] = time.time,
        find_free_bytes: Callable[[Path], int] = lambda folder: shutil.disk_usage(folder).free,
        max_waiting: int = MAX_WAITING,
    ) -> None:
        self.library = library
        self._clock, self._wall_clock, self._find_free_bytes = clock, wall_clock, find_free_bytes
        self._max_waiting = max_waiting
        self._came = threading.Condition()
        # Under the condition:
        self._acts: list[Callable[[], None]] = []
        self._is_urgent = False
        """One of them does not wait for the next flush."""
        self._waiting = self._dropped = self._lost = 0
        """Status reports and events that wait; that were dropped in this session; of those, not noted in it yet."""
        self._latest: Batch | None = None
        self._is_wanted = False
        self._is_stopped = False
        self._begun = 0
        self._error: Exception | None = None
        # Of the thread:
        self._thread: threading.Thread | None = None
        self._session: _Session | None = None
        self._tracker = MarkerTracker()
        self._pending: list[Marker] = []
        self._sleep: Sleep | None = None
        self._writer: SessionWriter | None = None
        self._synced_at = self._disk_checked_at = 0.0

    # Any thread

    def begin(self, port: str, baud_rate: int, module: str = "") -> None:
        """Starts recording; ends the current recording."""
        with self._came:
            if self._is_stopped:
                return
            self._is_wanted, self._error, self._dropped = True, None, 0
            self._begun += 1
            session = _Session(port, baud_rate, module, self._clock(), self._begun)
            self._put(partial(self._begin, session))
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name="dps-s recorder", daemon=True)
                self._thread.start()

    def on_batch(self, batch: Batch) -> None:
        """Records this batch, if a recording was begun."""
        count = len(batch.samples) + len(batch.events)
        with self._came:
            if not self._is_wanted:
                return
            if self._waiting + count + 1 > self._max_waiting:
                self._latest = batch._replace(samples=(), events=(), finished=())
                self._dropped += count
                self._lost += count
                return
            self._make_up()
            self._acts.append(partial(self._record, batch))
            self._waiting += count + 1

    def name_module(self, module: str) -> None:
        with self._came:
            if self._is_wanted:
                self._put(partial(self._name, module))

    def end(self) -> None:
        """Closes the recording. Idempotent."""
        with self._came:
            if self._is_wanted:
                self._is_wanted = False
                self._put(self._end)

    def settle(self, deadline_s: float) -> bool:
        """Waits until everything before is on disk or given up; False on timeout."""
        done = threading.Event()
        with self._came:
            if self._thread is None or self._is_stopped:
                return True
            self._put(self._flush)
            self._put(done.set)
        return done.wait(deadline_s)

    def stop(self, deadline_s: float = 0.4) -> bool:
        """Closes the recording and ends the thread; False on timeout. Idempotent."""
        with self._came:
            thread = self._thread
            if not self._is_stopped:
                self._is_wanted, self._is_stopped = False, True
                self._put(self._end)
        if thread is None:
            return True
        thread.join(deadline_s)
        return not thread.is_alive()

    def _put(self, act: Callable[[], None]) -> None:
        """Under the condition: to be done at once. Always fits."""
        self._make_up()
        self._acts.append(act)
        self._is_urgent = True
        self._came.notify_all()

    def _make_up(self) -> None:
        """Under the condition: notes what was dropped, and the state after it."""
        if self._latest is not None:
            self._acts += (partial(self._note_missing, self._lost), partial(self._record, self._latest))
            self._latest, self._lost = None, 0

    @property
    def is_recording(self) -> bool:
        """Whether a session is recorded, or will be from its first byte."""
        return self._is_wanted

    @property
    def path(self) -> Path | None:
        """Of the current recording; None before the first byte."""
        writer = self._writer
        return None if writer is None else writer.path

    @property
    def started_at(self) -> datetime | None:
        """When the current recording began, UTC; None before the first byte."""
        writer = self._writer
        return None if writer is None else writer.opening.started_at

    @property
    def wall_offset_s(self) -> float:
        """Of the current recording; 0 before the first byte."""
        writer = self._writer
        return 0.0 if writer is None else writer.opening.wall_offset_ns / NANOSECONDS

    @property
    def trouble(self) -> UserMessage | None:
        """Why recording failed; the next `begin` tries again."""
        error = self._error
        return None if error is None else stopped_message(error, self.library.folder)

    @property
    def dropped(self) -> int:
        """Status reports and events of this session that were lost because the disk was too slow."""
        return self._dropped

    # The thread

    def _work(self) -> None:
        is_stopping = False
        while not is_stopping:
            with self._came:
                self._came.wait_for(lambda: self._is_urgent, None if self._session is None else FLUSH_EVERY_S)
                acts, self._acts = self._acts, []
                self._waiting, self._is_urgent = 0, False
                is_stopping = self._is_stopped
            for act in acts:
                self._guarded(act)
            self._guarded(self._maintain)

    def _guarded(self, act: Callable[[], None]) -> None:
        """An error ends the recording, and nothing else."""
        try:
            act()
        except Exception as error:  # noqa: BLE001  the program goes on without a recording
            if not isinstance(error, OSError):
                _log.exception("The recorder met an error it did not expect")
            _log.warning("The session is no longer recorded: %s", error)
            session, self._session = self._session, None
            with self._came:
                if session is not None and session.number == self._begun:
                    self._is_wanted, self._error = False, error
            self._release()

    def _begin(self, session: _Session) -> None:
        self._guarded(self._close)
        self._session, self._sleep = session, None
        self._tracker, self._pending = MarkerTracker(), []

    def _note_missing(self, count: int) -> None:
        if self._writer is not None:
            self._writer.note(self._clock(), MarkerKind.MISSING.value, count=count)

    def _end(self) -> None:
        self._close()
        self._session = None

    def _record(self, batch: Batch) -> None:
        session = self._session
        if session is None:
            return
        sleep = batch.device.last_sleep
        if sleep is not None and sleep != self._sleep and self._writer is not None:
            self._end_session(sleep.ended_at)  # the clock may have stopped during the sleep
        self._sleep = sleep
        markers = self._pending + self._tracker.on_batch(batch)
        self._pending = []
        if self._writer is None:
            firsts = [first.at for first in (*batch.samples[:1], *batch.events[:1])]
            if not firsts:
                self._pending = markers
                return
            self._open(session, min(session.at, *firsts, *(marker.time_s for marker in markers)))
        if self._writer is not None:
            self._writer.put(batch, markers, self._tracker.limits)

    def _open(self, session: _Session, start_s: float) -> None:
        wall_offset_s = self._find_wall_offset_s()
        self.library.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        self.library.prune()
        self._check_disk()
        opening = Opening(
            started_at=datetime.fromtimestamp(start_s + wall_offset_s, UTC),
            start_s=start_s,
            port=session.port,
            baud_rate=session.baud_rate,
            module=session.module,
            station=_own_station(self.library.folder.parent),
            program=f"DPS-S Configurator {version()}",
            sequence=self.library.next_sequence(),
        )
        self._writer = SessionWriter(new_path(self.library.folder, opening.started_at), opening)
        self._synced_at = self._disk_checked_at = self._clock()

    def _name(self, module: str) -> None:
        if self._session is not None:
            self._session = self._session._replace(module=module)
        if self._writer is not None:
            self._writer.name_module(module)

    def _maintain(self) -> None:
        """Flushes, syncs, checks the disk, and ends a session that is too long, whose clock was set or whose file was
        deleted."""
        writer, now = self._writer, self._clock()
        if writer is None or self._session is None:
            return
        self._flush()
        if now - self._synced_at >= SYNC_EVERY_S:
            self._synced_at = now
            writer.sync()
        if now - self._disk_checked_at >= DISK_CHECK_EVERY_S:
            self._disk_checked_at = now
            self._check_disk()
        opening = writer.opening
        has_jumped = abs(self._find_wall_offset_s() - opening.wall_offset_s) > CLOCK_JUMP_S
        is_long = now - opening.start_s > MAX_SESSION_S or writer.size_bytes > self.library.max_bytes / 5
        if has_jumped or is_long or writer.is_deleted:
            self._end_session(now)

    def _find_wall_offset_s(self) -> float:
        """Wall clock minus monotonic clock, both read now: a slow disk is no jump of the clock."""
        return self._wall_clock() - self._clock()

    def _end_session(self, at: float) -> None:
        """The next one begins with the next byte, not before `at`."""
        self._close()
        if self._session is not None:
            self._session = self._session._replace(at=at)

    def _check_disk(self) -> None:
        if self._find_free_bytes(self.library.folder) < RESERVE_BYTES:
            self.library.free_space()
        if self._find_free_bytes(self.library.folder) < RESERVE_BYTES:
            raise OSError(errno.ENOSPC, "the disk is nearly full")

    def _flush(self, *, is_last: bool = False) -> None:
        if self._writer is not None:
            self._writer.flush(self._clock(), is_last=is_last)

    def _close(self) -> None:
        try:
            self._flush(is_last=True)
            if self._writer is not None:
                self._writer.sync()
        finally:
            self._release()

    def _release(self) -> None:
        if self._writer is not None:
            self._writer.close()
        self._writer = None


def _own_station(folder: Path) -> str:
    """Fingerprint of the station of this data folder; empty where it has none."""
    try:
        station = find_station(folder)
    except UserError:
        return ""
    return "" if station is None else fingerprint_of(station.public)
