"""Records what goes over one port, in a background thread: from the first byte to `end` one file.

A conversation that ends is a mark in it, not its end. `on_batch` only adds a batch to a bounded list, so a slow, full
or missing disk never delays the link. Where the list is full the recording ends, and says so.
"""

import errno
import logging
import math
import shutil
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import msgspec

from app import version
from app.captures.traffic import entries_of
from app.engine.conversation import ConversationView
from app.engine.worker import Batch
from app.recordings.library import RecordingLibrary
from app.recordings.markers import Marker, MarkerKind, MarkerTracker, ModuleLimits, limits_of
from app.recordings.session_file import POLLED, RX, STATUS, TX, Opening, RecordedReport, SessionWriter
from app.system.clock import Clock, steady_time
from app.text.messages import UserMessage, error_text, message
from protocol.messages import Direction
from protocol.translatable import marked

_log = logging.getLogger(__name__)

FLUSH_EVERY_S = 0.5
# The disk is made to keep what was written, and is asked for its free space.
SYNC_EVERY_S = 30.0
# Left free for the store, which must be able to keep an intent.
RESERVE_BYTES = 256 * 1024**2
# How many names are tried for a new file: more than there are ports that may begin at once.
NAMES_TRIED = 256
# Batches that wait for the thread; more than a minute of the fastest stream.
MAX_WAITING = 10_000
# After this, with a fifth of what the library may hold, or where it is full, it goes on in the next file.
MAX_SESSION_S = 24 * 3600.0


class Recorder:
    """One recording. Public methods may be called from any thread and return at once, except `stop`."""

    def __init__(
        self,
        library: RecordingLibrary,
        port: str,
        baud_rate: int,
        clock: Clock = steady_time,
        wall_clock: Clock = time.time,
    ) -> None:
        self._library, self._port, self._baud_rate = library, port, baud_rate
        self._clock, self._wall_clock, self._begun_at = clock, wall_clock, clock()
        self.is_recording = True
        # Its files, in order: none before the first byte, more than one after a day.
        self.paths: list[Path] = []
        # Why it ended early.
        self.trouble: UserMessage | None = None
        self._writer: SessionWriter | None = None
        self._tracker = MarkerTracker()
        # What the file does not tell of yet, and what it does.
        self._markers: list[Marker] = []
        self._named: tuple[str, ConversationView] | None = None
        self._polled_s: dict[str, float] = {}
        self._limits = ModuleLimits()
        self._line_ns = 0
        self._synced_at = 0.0
        # What its thread is to do, and whether at once.
        self._acts: deque[Callable[[], None]] = deque()
        self._is_urgent = threading.Event()
        self._thread = threading.Thread(target=self._work, name="dps-s recorder", daemon=True)
        self._thread.start()

    def on_batch(self, batch: Batch) -> None:
        if self.is_recording and len(self._acts) >= MAX_WAITING:
            self.trouble = message(marked("Not recorded any more: the disk is too slow."))
            self.end()
        elif self.is_recording:
            self._acts.append(partial(self._record, batch))

    def name_module(self, module: str, conversation: ConversationView) -> None:
        """A person said which module it is in this conversation."""
        if self.is_recording:
            self._acts.append(partial(self._name, module, conversation))

    def end(self) -> None:
        """Closes the file once everything is in it. Idempotent."""
        self.is_recording = False
        self._is_urgent.set()

    def stop(self, deadline_s: float = 0.4) -> bool:
        """Ends, and waits for it; False on timeout. Idempotent."""
        self.end()
        self._thread.join(deadline_s)
        return not self._thread.is_alive()

    @property
    def started_at(self) -> datetime | None:
        """When the file that is being written was begun."""
        writer = self._writer
        return None if writer is None else writer.opening.started_at

    # In its thread

    def _work(self) -> None:
        while self.is_recording or self._acts:
            self._is_urgent.wait(FLUSH_EVERY_S)
            self._is_urgent.clear()
            while self._acts:
                self._do(self._acts.popleft())
            self._do(self._maintain)
        self._do(self._close)

    def _do(self, act: Callable[[], None]) -> None:
        """An error ends this recording, and nothing else."""
        try:
            act()
        except Exception as error:  # noqa: BLE001
            if not isinstance(error, OSError):
                _log.exception("The recorder met an error it did not expect")
            _log.warning("Not recorded any more: %s", error)
            is_full = isinstance(error, OSError) and error.errno == errno.ENOSPC
            why = message(marked("the disk is full")) if is_full else error_text(error)
            self.trouble = message(marked("Not recording to {folder}: {why}."), folder=self._library.folder, why=why)
            self.is_recording = False
            self._acts.clear()
            if self._writer is not None:
                self._writer.close()
                self._writer = None

    def _record(self, batch: Batch) -> None:
        self._markers += self._tracker.on_batch(batch)
        writer = self._writer
        if writer is None:
            firsts = [first.at for first in (*batch.samples[:1], *batch.events[:1])]
            if not firsts:
                return
            writer = self._writer = self._open(min(self._begun_at, *firsts))
            if self._named is not None and self._named[1].number == batch.conversation.number:
                self._name(*self._named)
        for entry in entries_of(batch.events, 0.0):
            # Strictly ascending times tell the order of both directions.
            self._line_ns = max(self._line_ns + 1, writer.wall_ns(entry.at_s))
            writer.add(RX if entry.direction is Direction.MODULE_TO_HOST else TX, self._line_ns, entry.raw)
        for sample in batch.samples:
            report = RecordedReport(sample.tilt_deg, sample.acceleration_g, sample.triggered, sample.active)
            writer.add(STATUS, writer.wall_ns(sample.at), msgspec.json.encode(report))
            writer.state.reports += 1
            writer.state.was_triggered |= sample.triggered
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
        self._named, writer = (module, conversation), self._writer
        if writer is not None:
            # A name holds from the beginning of its conversation on.
            writer.note(max(conversation.began_at, writer.opening.start_s), MarkerKind.NAMED.value, module=module)
            writer.state.modules = tuple(dict.fromkeys((*writer.state.modules, module)))

    def _open(self, start_s: float) -> SessionWriter:
        self._library.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        self._library.prune()
        self._check_disk()
        # Values polled before the beginning are in the previous recording.
        self._polled_s = dict.fromkeys(POLLED, math.nextafter(start_s, -math.inf))
        self._line_ns, self._limits = 0, ModuleLimits()
        opening = Opening(
            started_at=datetime.fromtimestamp(start_s + self._wall_clock() - self._clock(), UTC),
            start_s=start_s,
            port=self._port,
            baud_rate=self._baud_rate,
            program=f"DPS-S Configurator {version()}",
        )
        _log.debug("Recording %s", self._port)
        for _ in range(NAMES_TRIED):
            # Another port or program that begins at the same time may have taken the name since it was found free.
            with suppress(FileExistsError):
                writer = SessionWriter(self._library.new_path(opening.started_at), opening)
                self.paths.append(writer.path)
                return writer
        raise OSError(errno.EEXIST, "no name is free")

    def _check_disk(self) -> None:
        self._synced_at = self._clock()
        if shutil.disk_usage(self._library.folder).free < RESERVE_BYTES:
            raise OSError(errno.ENOSPC, "the disk is nearly full")

    def _maintain(self) -> None:
        """Flushes, syncs, checks the disk, and goes on in the next file where this one is long enough."""
        writer, now = self._writer, self._clock()
        if writer is None:
            return
        writer.flush(now)
        if now - self._synced_at >= SYNC_EVERY_S:
            writer.sync()
            self._check_disk()
        if writer.is_full(self._library.max_bytes / 5) or now - writer.opening.start_s > MAX_SESSION_S:
            self._close()
            self._begun_at = now

    def _close(self) -> None:
        if self._writer is not None:
            self._writer.flush(self._clock(), is_last=True)
            self._writer.sync()
            self._writer.close()
            self._writer = None
