"""Once a day a copy of the store, in a thread and over a connection of its own: no act's intent waits for it."""

import logging
import os
import sqlite3
import threading
from collections.abc import Callable
from contextlib import closing, suppress
from datetime import datetime
from pathlib import Path

from app.store.opening import BUSY_S, COPIES, copies_of, copy_name, is_good
from app.system.files import private_opener

_log = logging.getLogger(__name__)

COPIES_KEPT = 7
CLOSING_LIMIT_S = 0.3


class Copier:
    """Copies an open store. Any thread may call."""

    def __init__(self, path: Path, clock: Callable[[], datetime]) -> None:
        self._path = path
        self._clock = clock
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._connection: sqlite3.Connection | None = None
        self._is_closed = False

    def start_if_due(self) -> None:
        """Returns at once; one copy at a time."""
        with self._lock:
            is_running = self._thread is not None and self._thread.is_alive()
            if not is_running and not self._is_closed:
                self._thread = threading.Thread(target=self._run, name="dps-s copies", daemon=True)
                self._thread.start()

    def close(self) -> None:
        """Idempotent. A copy under way has 0.3 s to end, and is then broken off."""
        with self._lock:
            self._is_closed = True
        if self._thread is not None:
            self._thread.join(CLOSING_LIMIT_S)
        connection = self._connection
        if connection is not None:
            with suppress(sqlite3.Error):
                connection.interrupt()

    def _run(self) -> None:
        target = self._path.parent / COPIES / copy_name(self._path, self._clock())
        draft = target.with_suffix(".part")
        try:
            if target.exists() or not self._is_worth_it():
                return
            target.parent.mkdir(exist_ok=True)
            self._copy(draft)
            draft.replace(target)
            for old in copies_of(self._path, self._clock())[COPIES_KEPT:]:
                old.unlink(missing_ok=True)
        except (sqlite3.Error, OSError) as error:
            _log.warning("The store could not be copied: %s", error)

    def _is_worth_it(self) -> bool:
        """A store that holds nothing but the name of its station waits until it is opened again."""
        with closing(sqlite3.connect(f"{self._path.as_uri()}?mode=ro", uri=True, timeout=BUSY_S)) as connection:
            return len(connection.execute("SELECT 1 FROM facts LIMIT 2").fetchall()) > 1

    def _copy(self, draft: Path) -> None:
        """Whole and on the disk. Raises `sqlite3.Error`, also where the copy is not good, or OSError."""
        draft.unlink(missing_ok=True)
        with open(draft, "xb", opener=private_opener):
            pass
        source = sqlite3.connect(f"{self._path.as_uri()}?mode=ro", uri=True, timeout=BUSY_S, check_same_thread=False)
        with closing(source):
            self._connection = source
            try:
                source.execute("VACUUM INTO ?", (str(draft),))
            finally:
                self._connection = None
        if not is_good(draft):
            raise sqlite3.DatabaseError("the copy is not good: the store is damaged")
        with draft.open("rb+") as file:
            os.fsync(file.fileno())  # VACUUM INTO itself does not wait for the disk
