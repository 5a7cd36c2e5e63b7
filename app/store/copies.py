"""Backup copies of the store, and restoring from them.

A store that was there is copied at its opening, and by the window once a day while it runs, in a thread of its own
(SQLite's backup interface: readers and writers go on meanwhile). The newest copies are kept, and of older days one
each. A store that is damaged, emptied or gone is restored from the newest copy that is good; the copy stays, and so
does the damaged file under another name.
"""

import logging
import sqlite3
import threading
from collections.abc import Callable, Sequence
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

from app.store.schema import check_copy
from app.system.files import draft_of, write_whole

_log = logging.getLogger(__name__)

FOLDER = "copies"
EVERY_S = 24 * 3600.0
AT_OPENING_S = 3600.0
"""Age of the newest copy from which one is made at the opening: commands open the store for a moment each."""
MIN_COPIES = 4
MAX_COPY_DAYS = 7
AHEAD = timedelta(minutes=1)
"""A clock may be corrected by less."""
PAGES_AT_ONCE = 256
"""Between two lots a copy that nobody waits for any more is broken off."""
REST_S = 0.005
CLOSING_LIMIT_S = 0.3
_STAMP = "%Y%m%d-%H%M%S"


def copies_of(store: Path, now: datetime) -> list[Path]:
    """The newest first; behind them those of a clock that was ahead, which hold less."""
    latest = _name(store, now + AHEAD)
    found = (store.parent / FOLDER).glob(f"{store.stem}.*{store.suffix}")
    return sorted(found, key=lambda copy: (copy.name <= latest, copy.name), reverse=True)


def _name(store: Path, at: datetime) -> str:
    return f"{store.stem}.{at.astimezone(UTC).strftime(_STAMP)}{store.suffix}"


def copied_at(copy: Path) -> datetime | None:
    try:
        stamp = copy.name.split(".")[1]
        at = datetime.fromisoformat(stamp).replace(tzinfo=UTC)  # `strptime` takes 3 ms the first time
        return at if at.strftime(_STAMP) == stamp else None
    except (ValueError, IndexError):
        return None


def copy_store(store: Path, now: datetime, *, is_wanted: Callable[[], bool] = lambda: True) -> Path:
    """A copy of the open store, whole or not at all. Raises OSError, also where it is not wanted any more, or
    `sqlite3.Error`, also where the copy is not good: then the store itself is not, and the older copies stay."""

    def go_on(_status: int, _remaining: int, _total: int) -> None:
        if not is_wanted():
            raise InterruptedError("the program closes")

    target = store.parent / FOLDER / _name(store, now)
    target.parent.mkdir(exist_ok=True)
    with closing(sqlite3.connect(f"{store.as_uri()}?mode=ro", uri=True)) as source:
        # One snapshot for all lots: else SQLite starts again whenever another connection has written.
        source.execute("BEGIN")
        source.execute("SELECT 1 FROM sqlite_schema").fetchone()
        write_copy(source, target, go_on)
    for old in to_drop(copies_of(store, now)):
        old.unlink(missing_ok=True)
    return target


def write_copy(source: sqlite3.Connection, target: Path, go_on: Callable[[int, int, int], None] | None = None) -> None:
    """Whole or not at all; in place of a file that is there. Raises OSError or `sqlite3.Error`. `go_on`: called between
    two lots, and breaks off by raising."""
    with draft_of(target) as draft, closing(sqlite3.connect(draft)) as copy:
        source.backup(copy, pages=-1 if go_on is None else PAGES_AT_ONCE, progress=go_on, sleep=REST_S)
        copy.execute("PRAGMA journal_mode = DELETE")  # the copy is one file
        check_copy(copy)


def to_drop(copies: Sequence[Path]) -> list[Path]:
    """Of the copies, the newest first, those that are too many: kept are the newest, and the newest of each day."""
    days: set[str] = set()
    drop = []
    for number, copy in enumerate(copies):
        at = copied_at(copy)
        if at is None:
            continue  # not one of ours
        day = f"{at:%Y%m%d}"
        if number >= MIN_COPIES and (day in days or len(days) >= MAX_COPY_DAYS):
            drop.append(copy)
        days.add(day)
    return drop


def restore(store: Path, now: datetime) -> Path | None:
    """Put the newest good copy in the store's place, which is free; which one it was, None where there is none."""
    for copy in copies_of(store, now):
        try:
            with closing(sqlite3.connect(f"{copy.as_uri()}?mode=ro", uri=True)) as connection:
                check_copy(connection)
            write_whole(store, copy.read_bytes())
        except (sqlite3.Error, OSError, ValueError) as error:
            _log.warning("The copy %s cannot be used: %s", copy, error)
            continue
        return copy
    return None


class Copier:
    """Copies an open store in a thread of its own."""

    def __init__(self, store: Path, clock: Callable[[], datetime]) -> None:
        self._store, self._clock = store, clock
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def start_if_due(self, after_s: float = EVERY_S) -> None:
        """Where the newest copy is older. Returns at once; one copy at a time."""
        is_running = self._thread is not None and self._thread.is_alive()
        if not is_running and not self._stop.is_set() and self._is_due(after_s):
            self._thread = threading.Thread(target=self._run, name="dps-s copies", daemon=True)
            self._thread.start()

    def stop(self) -> None:
        """Idempotent. A copy under way has 0.3 s to end, as a command needs it, and as much again when it is broken
        off."""
        if self._thread is not None:
            self._thread.join(CLOSING_LIMIT_S)
            self._stop.set()
            self._thread.join(CLOSING_LIMIT_S)
        self._stop.set()

    def _is_due(self, after_s: float) -> bool:
        now = self._clock()
        newest = next((at for at in map(copied_at, copies_of(self._store, now)) if at is not None), None)
        return newest is None or not 0 <= (now - newest).total_seconds() < after_s

    def _run(self) -> None:
        try:
            copy_store(self._store, self._clock(), is_wanted=lambda: not self._stop.is_set())
        except (sqlite3.Error, OSError, ValueError) as error:  # ValueError: a folder whose name is no address
            _log.warning("The store could not be copied: %s", error)
