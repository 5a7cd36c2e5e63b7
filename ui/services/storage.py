"""Shared storage of the pages: store, journal, recordings, pending edits."""

import logging
import threading
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from app.engine.setting_changes import ChangedSetting
from app.engine.snapshots import Snapshot
from app.engine.target import Target
from app.safety.journal import Journal, NoJournal
from app.store.database import StoreFault, StoreTrouble
from app.store.left_active import LeftActive
from app.store.store import Store, open_store
from app.store.store_journal import UNNAMED, KnownAs, StoreJournal
from app.store.stream_memory import StreamMemory
from app.system.folders import data_folder
from ui.core.port_connection import PortConnection
from ui.services.recording_jobs import RecordingJobs
from ui.services.session_recording import SessionRecording

_log = logging.getLogger(__name__)
ORIGIN = "window"
RECORDINGS = "recordings"
"""The folder beside the store."""
RECORDER_LIMIT_S = 0.1
"""For the last lines of a recording, when the window closes."""


class Storage:
    """The store is opened by `open_store`, else when it is first asked for."""

    def __init__(self, folder: Path | None = None) -> None:
        self.left_active: tuple[LeftActive, ...] = ()
        """Modules that the audit log leaves ACTIVE; see `LeftActiveWatch`."""
        self._folder = folder
        self._recorded: list[SessionRecording] = []
        self.recordings = RecordingJobs(self._recordings_folder)
        self._store: Store | StoreTrouble | None = None
        self._opening = threading.Lock()
        self._is_closed = False

    @property
    def _recordings_folder(self) -> Path | None:
        return None if self._folder is None else self._folder / RECORDINGS

    @property
    def folder(self) -> Path:
        """Of the store and of what belongs to it."""
        return self._folder or data_folder()

    @property
    def store(self) -> Store | StoreTrouble:
        """The store, or why there is none."""
        return self.open_store()

    def open_store(self) -> Store | StoreTrouble:
        """Open, check and migrate the store, which may take long. Any thread may call. Idempotent; after `close` it
        returns a `StoreTrouble`."""
        with self._opening:
            if self._store is None and not self._is_closed:
                try:
                    self._store = open_store(self._folder)
                except StoreTrouble as trouble:
                    _log.warning("There is no store: %s", trouble)
                    self._store = trouble
            if self._store is None or self._is_closed:
                self._close_store()
                return StoreTrouble(StoreFault.FAILED, self.folder, "closed")
            return self._store

    @property
    def notice(self) -> str | None:
        """What a person should know about the store, in the language in use."""
        store = self.store
        notice = store.notice if isinstance(store, Store) else store.message
        return None if notice is None else notice.translated()

    def new_recording(self, port: PortConnection) -> SessionRecording:
        """Of one more port, into the same library; ended by `close`."""
        recording = SessionRecording(port, self._recordings_folder)
        self._recorded.append(recording)
        return recording

    def journal(self, target: Target | None, known_as: KnownAs = UNNAMED) -> Journal:
        store = self.store
        if target is None or not isinstance(store, Store):
            return NoJournal()
        return StoreJournal(store, port=target.device, origin=ORIGIN, adapter=target.identity, known_as=known_as)

    def store_snapshot(self, snapshot: Snapshot, port: str, module: str = "") -> Future[int] | None:
        """Any thread may call; the future is done when the snapshot is on disk. None if there is no store.

        `module`: its name, where it has one.
        """
        store = self._store
        if self._is_closed or not isinstance(store, Store):
            return None
        return store.queue.submit(lambda: store.store_snapshot(snapshot, port=port, module=module))

    def stream_memory(self, target: Target) -> StreamMemory:
        if target.is_simulated:
            return StreamMemory()
        store = self.store
        return StreamMemory(store if isinstance(store, Store) else None, target.key)

    def copy_if_due(self) -> None:
        if isinstance(self._store, Store) and not self._is_closed:
            self._store.database.copy_if_due()

    def close(self) -> None:
        """Close permanently, so that running work cannot open the store again. Idempotent."""
        self.recordings.stop()
        for recording in self._recorded:
            recording.stop(0.0)  # all at once
        stopped = [recording.stop(RECORDER_LIMIT_S) for recording in self._recorded]
        if not all(stopped):
            _log.warning("The recording was not closed within %s s; what was written is there", RECORDER_LIMIT_S)
        self._is_closed = True
        self._close_store()

    def _close_store(self) -> None:
        if isinstance(self._store, Store):
            self._store.close()


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
