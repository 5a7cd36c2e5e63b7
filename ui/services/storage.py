"""Shared storage of the window: store, journal, recordings."""

import logging
from concurrent.futures import wait
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from app.engine.target import Target
from app.safety.journal import Journal
from app.safety.left_active import LeftActive
from app.store.acts import StoreJournal, StreamMemory, Where
from app.store.fact_store import OPENING, Store, StoreError, unusable
from protocol.translatable import marked

if TYPE_CHECKING:  # it loads zstandard, which the window's first paint does not wait for
    from app.recordings.library import RecordingLibrary

_log = logging.getLogger(__name__)

ORIGIN = "window"
# For the last lines of a recording, when the window closes.
RECORDER_LIMIT_S = 0.1


class Storage(QObject):
    """The store opens in its own thread once it is first asked for, and nobody here waits for it."""

    # It is open, or there is none; emitted in the window's thread (`ui/main.py`).
    opened = Signal()

    def __init__(self, folder: Path | None = None) -> None:
        super().__init__()
        # Modules that the audit log leaves ACTIVE; see `LeftActiveWatch`.
        self.left_active: tuple[LeftActive, ...] = ()
        # One of each port; ended by `close`.
        self.recorded: list[Any] = []
        self._store = Store(folder, starts_late=True)
        self._is_closed = False

    @cached_property
    def library(self) -> "RecordingLibrary":
        """Return the library of recordings."""
        from app.recordings.library import RecordingLibrary

        return RecordingLibrary(self.folder / "recordings")

    @property
    def folder(self) -> Path:
        """The folder of the store and of what belongs to it."""
        return self._store.folder

    @property
    def begun(self) -> Store | None:
        """The store, which opens; None once it is closed. Any thread may call."""
        if self._is_closed:
            return None
        self._store.start()
        return self._store

    @property
    def store(self) -> Store | StoreError:
        """The store once it is open, or why there is none (yet). Never waits."""
        store = self.begun
        if store is None:
            return unusable(self.folder, marked("it is closed"))
        if not store.opened.done():
            return unusable(store.path, OPENING)
        trouble = store.opened.exception()
        return trouble if isinstance(trouble, StoreError) else store

    @property
    def ready(self) -> Store | None:
        """The store, once it is open. Never waits."""
        store = self.store
        return store if isinstance(store, Store) else None

    def open_store(self) -> Store | StoreError:
        """Waits until it is open: not for the window's thread."""
        store = self.begun
        if store is not None:
            wait([store.opened])
        return self.store

    @property
    def notice(self) -> str | None:
        """The sentence on what a person should know about the store once it is open, in the language in use."""
        store = self.store
        if isinstance(store, StoreError):
            return store.sentence
        notice = store.opened.result()
        return None if notice is None else notice.translated()

    def journal(self, where: Where | None) -> Journal:
        """Return the journal of a store that may still be opening: LOCK waits for no entry, and an act for its own."""
        store = self.begun
        if where is None or store is None or (store.opened.done() and self.ready is None):
            return Journal()
        return StoreJournal(store, lambda: where)

    def stream_memory(self, target: Target) -> StreamMemory:
        return StreamMemory() if target.is_simulated else StreamMemory(self.begun, target.key)

    def close(self) -> None:
        """Close permanently, so that running work cannot open the store again. Idempotent."""
        for recording in self.recorded:
            recording.stop(0.0)  # all at once
        stopped = [recording.stop(RECORDER_LIMIT_S) for recording in self.recorded]
        if not all(stopped):
            _log.warning("The recording was not closed within %s s; what was written is there", RECORDER_LIMIT_S)
        self._is_closed = True
        self._store.close()
