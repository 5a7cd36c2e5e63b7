"""Shared storage of the pages: store, journal, recordings, pending edits; every session is recorded."""

import logging
import threading
from collections.abc import Callable
from concurrent.futures import Future, wait
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from PySide6.QtCore import QObject, Signal

from app.engine.device import DeviceView
from app.engine.setting_changes import ChangedSetting
from app.engine.snapshots import Snapshot
from app.engine.target import Target
from app.engine.worker import Batch, Connection, PortState
from app.recordings.markers import MarkerKind, MarkerTracker
from app.safety.journal import Journal, NoJournal
from app.store.fact_store import Store
from app.store.left_active import KnownAs, LeftActive
from app.store.modules import store_snapshot
from app.store.rows import Row
from app.store.store_journal import UNNAMED, StoreJournal
from app.store.stream_memory import StreamMemory
from app.store.trouble import StoreFault, StoreTrouble
from app.system.folders import data_folder
from app.text.messages import UserMessage
from protocol.events import BREAKS
from ui.core.port_connection import PortConnection
from ui.services.recording_jobs import RecordingJobs

if TYPE_CHECKING:
    from app.recordings.recorder import Recorder  # loads numpy, which the window's first paint does not wait for

_log = logging.getLogger(__name__)


class RecordingState(NamedTuple):
    """State of the running recording as the window shows it. `trouble`: why nothing is written."""

    since: datetime | None = None
    """Aware; None: nothing is being written."""
    dropped: int = 0
    trouble: UserMessage | None = None


class SessionRecording:
    """Of one port, from opening it until it is closed: where it is in doubt which module answers, and at each break of
    the conversation until a person has said it, the next recording begins; one without a name that was broken gets
    none. The worker's batches go to the recorder from the worker's own thread, so that a window that stalls or closes
    costs the recording nothing."""

    def __init__(self, port: PortConnection, recordings: RecordingJobs) -> None:
        self._port, self._recordings = port, recordings
        self._recorder: Recorder | None = None
        """From the first session on."""
        self._lock = threading.Lock()
        self._opening: int | None = None
        """The number of the opening that is recorded."""
        self._is_in_doubt = False
        """It is in doubt which module answers."""
        self._tracker, self._breaks = MarkerTracker(), 0
        """And its breaks when the recording began."""
        self._module = ""
        self.path: Path | None = None
        """Of what was recorded last of this conversation; None before the first byte."""
        self._former_path: Path | None = None
        """The recorder still has it while the next file is not begun."""

    def recorded(self, deliver: Callable[[Batch], None]) -> Callable[[Batch], None]:
        def both(batch: Batch) -> None:
            try:
                self._on_batch(batch)
            except Exception:  # noqa: BLE001  recording must never end the link
                _log.exception("A batch could not be recorded")
            deliver(batch)

        return both

    @property
    def sign(self) -> RecordingState:
        recorder = self._recorder
        if recorder is None:
            return RecordingState()
        trouble = None if recorder.is_recording else recorder.trouble
        return RecordingState(recorder.started_at, recorder.dropped, trouble)

    def stop(self, deadline_s: float) -> bool:
        """End the recording and its thread; whether that was done in time. What was written before is safe in any
        case."""
        return self._recorder is None or self._recorder.stop(deadline_s)

    def settle(self) -> None:
        """Waits, for a moment at most, until the file holds what has come. Not for the window's thread."""
        if self._recorder is not None:
            self._recorder.settle(SETTLE_LIMIT_S)

    def _on_batch(self, batch: Batch) -> None:
        """In the worker's thread."""
        connection, is_in_doubt = batch.connection, not batch.identity.is_settled
        with self._lock:
            if connection.state is PortState.OPEN:
                # Once a person has settled a doubt, what was recorded since it arose is of the module that they named.
                is_doubted = any(one.kind is MarkerKind.DOUBTED for one in self._tracker.on_batch(batch))
                is_next = is_in_doubt or connection.opening != self._opening
                if is_doubted or (is_next and not self._is_in_doubt):
                    if self._recorder is not None and connection.opening == self._opening:
                        self._recorder.on_batch(_without_content(batch))  # says in its file from where it is in doubt
                    self._begin(connection, "" if is_in_doubt else self._module)
                self._opening, self._is_in_doubt = connection.opening, is_in_doubt
            else:
                self._opening, self._is_in_doubt = None, False
                self._tracker = MarkerTracker()
            if self._recorder is not None:
                self._recorder.on_batch(batch)
                path = self._recorder.path
                self.path = path if path not in (None, self._former_path) else self.path
                if self._opening is None:
                    self._recorder.end()
            # A recording needs every report, whatever page is shown.
            self._port.stream.is_recorded = self._recorder is not None and self._recorder.is_recording

    def _begin(self, connection: Connection, module: str) -> None:
        from app.recordings.recorder import Recorder

        if self._recorder is None:
            self._recorder = Recorder(self._recordings.library)
        self.path, self._former_path, self._breaks = None, self._recorder.path, self._tracker.breaks
        self._recorder.begin(connection.port, connection.baud_rate, module)

    def name_module(self, name: str) -> None:
        """Only of the module that is shown, and while it is not in doubt."""
        with self._lock:
            self._module = name
            is_recorded = self._opening == self._port.connection.opening and not self._is_in_doubt
            if not name or not is_recorded or self._recorder is None:
                return
            if self._tracker.breaks != self._breaks:
                self._begin(self._port.connection, name)
            else:
                self._recorder.name_module(name)


def _without_content(batch: Batch) -> Batch:
    """Only when the conversation broke, and that it is in doubt."""
    breaks = tuple(event for event in batch.events if isinstance(event, BREAKS))
    return batch._replace(samples=(), events=breaks, finished=(), device=DeviceView())


ORIGIN = "window"
RECORDINGS = "recordings"
"""The folder beside the store."""
SETTLE_LIMIT_S = 2.0
RECORDER_LIMIT_S = 0.1
"""For the last lines of a recording, when the window closes."""


class Storage(QObject):
    """The store opens in its own thread once it is first asked for, and nobody here waits for it. `opened`: it is open,
    or there is none; emitted in the window's thread (`ui/main.py`)."""

    opened = Signal()

    def __init__(self, folder: Path | None = None) -> None:
        super().__init__()
        self.left_active: tuple[LeftActive, ...] = ()
        """Modules that the audit log leaves ACTIVE; see `LeftActiveWatch`."""
        self._folder = folder
        self._recorded: list[SessionRecording] = []
        self.recordings = RecordingJobs(None if folder is None else folder / RECORDINGS)
        self._opening: Store | None = None
        self._lock = threading.Lock()
        self._is_closed = False

    @property
    def folder(self) -> Path:
        """Of the store and of what belongs to it."""
        return self._folder or data_folder()

    @property
    def store(self) -> Store | StoreTrouble:
        """The store once it is open, or why there is none (yet). Never waits."""
        store = self.begun
        if self._is_closed or store is None:
            return StoreTrouble(StoreFault.FAILED, self.folder, "closed")
        if not store.opened.done():
            return StoreTrouble(StoreFault.OPENING, store.path)
        trouble = store.opened.exception()
        return trouble if isinstance(trouble, StoreTrouble) else store

    def open_store(self) -> Store | StoreTrouble:
        """Waits until it is open: not for the window's thread."""
        store = self.begun
        if store is not None:
            wait([store.opened])
        return self.store

    @property
    def notice(self) -> str | None:
        """What a person should know about the store once it is open, in the language in use."""
        store = self.store
        if isinstance(store, StoreTrouble):
            return store.sentence
        notice = store.opened.result()
        return None if notice is None else notice.translated()

    def new_recording(self, port: PortConnection) -> SessionRecording:
        """Of one more port, into the same library; ended by `close`."""
        self._recorded.append(SessionRecording(port, self.recordings))
        return self._recorded[-1]

    def journal(self, target: Target | None, known_as: KnownAs = UNNAMED) -> Journal:
        """Of a store that may still be opening: LOCK waits for no entry, and an act for its own."""
        store = self.begun
        if target is None or store is None or (isinstance(self.store, StoreTrouble) and store.opened.done()):
            return NoJournal()
        return StoreJournal(store, port=target.device, origin=ORIGIN, adapter=target.identity, known_as=known_as)

    def store_snapshot(self, snapshot: Snapshot, port: str, module: str = "") -> "Future[Row] | None":
        """Any thread may call; the future is done when the snapshot is on disk. None if there is no store.

        `module`: its name, where it has one.
        """
        store = self.begun
        if store is None:
            return None
        return store.write(partial(store_snapshot, snapshot=snapshot, port=port, module=module))

    def stream_memory(self, target: Target) -> StreamMemory:
        return StreamMemory() if target.is_simulated else StreamMemory(self.begun, target.key)

    def copy_if_due(self) -> None:
        store = self.begun
        if store is not None:
            store.copy_if_due()

    def close(self) -> None:
        """Close permanently, so that running work cannot open the store again. Idempotent."""
        self.recordings.stop()
        for recording in self._recorded:
            recording.stop(0.0)  # all at once
        stopped = [recording.stop(RECORDER_LIMIT_S) for recording in self._recorded]
        if not all(stopped):
            _log.warning("The recording was not closed within %s s; what was written is there", RECORDER_LIMIT_S)
        with self._lock:
            self._is_closed = True
        if self._opening is not None:
            self._opening.close()

    @property
    def begun(self) -> Store | None:
        """None once it is closed. Any thread may call."""
        with self._lock:
            if self._opening is None and not self._is_closed:
                self._opening = Store(self._folder)
            return None if self._is_closed else self._opening


class PendingEdits(QObject):
    """Edits that leaving would lose, and what the module changed; the pages set these functions."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.count: Callable[[], int] = int
        self.discard: Callable[[], object] = bool
        self.has_profile: Callable[[], bool] = bool
        """A profile is edited and not saved, which closing the window would lose."""
        self.find_foreign: Callable[[], tuple[ChangedSetting, ...]] = tuple
        """Settings of the module that read differently than before and were not written here."""
