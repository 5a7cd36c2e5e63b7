"""Opens, checks and migrates the SQLite file; never overwrites one that it cannot read.

    not there        made
    ours             checked, its copy kept before a migration, migrated
    damaged, another's   set aside under another name; restored from the newest good copy, else a new one is made; said
    gone, emptied    restored from the newest good copy, where there is one; said
    gone, replaced while it is open  see `app.store.moved`
    a newer version's left alone; the program goes on without; said
    not writable     the program goes on without; said

Every commit is on the disk when the call returns (WAL, `synchronous=FULL`). Each waits for the disk, so what belongs
together is committed together (`transaction`). One connection writes and one reads, each under a lock of its own: any
thread may call, and reading waits for no commit. Two programs share the file through SQLite's own locks.
"""

import logging
import sqlite3
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from app.store.copies import AT_OPENING_S, Copier, copied_at, restore
from app.store.moved import MovedOn, Opened, Places, companions, places, put_back, set_aside
from app.store.schema import APPLICATION_ID, StoreLayout, check, make_tables
from app.store.trouble import StoreFault, StoreTrouble, trouble_of
from app.system.files import draft_of
from app.text.messages import UserMessage, joined, message
from protocol.translatable import marked

_log = logging.getLogger(__name__)
__all__ = ["StoreFault", "StoreTrouble", "trouble_of"]

FILE_NAME = "dps-s.sqlite"
BUSY_S = 5.0
"""How long another program may hold the file before a call fails."""
ASIDE = marked("The records cannot be used and are kept as {file}.")
_MAGIC = b"SQLite format 3\x00"

Clock = Callable[[], datetime]


def utc_now() -> datetime:
    return datetime.now(UTC)


class Database:
    """Made by `open_database`. Every method may be called from any thread and raises `StoreTrouble`."""

    def __init__(
        self,
        path: Path,
        layout: StoreLayout,
        clock: Clock,
        *,
        copies: Copier | None = None,
        notice: UserMessage | None = None,
    ) -> None:
        """`notice`: that an old file was set aside when it was opened."""
        self.path = path
        self.notice = notice
        self._copies = copies
        self._clock = clock
        self._layout = layout
        self._end: StoreTrouble | None = None
        """Why it is no longer used."""
        self._open()
        self._lock = threading.RLock()
        self._reading_lock = threading.Lock()
        self._together_in: int | None = None
        """The thread inside `transaction`; it also reads what it has not committed yet."""

    def _open(self) -> None:
        self._connection, self._reading = _connect_both(self.path, self._layout)
        self._places: Places | None = places(self.path)
        """None: closed, or no longer used."""

    def now(self) -> str:
        return self._clock().isoformat(timespec="milliseconds")

    def write(self, statement: str, values: Sequence[Any] = ()) -> int:
        """Execute and commit one statement; returns the id of the inserted row. Durable on return."""
        with self.transaction():
            return self._execute(statement, values).lastrowid or 0

    def write_all(self, statement: str, rows: Iterable[Sequence[Any]]) -> None:
        """One statement for each row; within `transaction` one commit."""
        with self._lock:
            try:
                self._connection.executemany(statement, rows)
            except sqlite3.Error as error:
                raise self._trouble(error) from error

    def read(self, query: str, values: Sequence[Any] = ()) -> list[Any]:
        """Everything that was committed; within `transaction` also what is not committed yet."""
        is_inside = self._together_in == threading.get_ident()
        with self._lock if is_inside else self._reading_lock:
            connection = self._connection if is_inside else self._reading
            try:
                return connection.execute(query, values).fetchall()
            except sqlite3.Error as error:
                raise self._trouble(error) from error

    def attach(self, path: Path, name: str) -> None:
        """Another file to read from, under its own name; whoever reads there otherwise does not wait for it."""
        with self._reading_lock:
            try:
                self._reading.execute(f"ATTACH ? AS {name}", (str(path),))
            except sqlite3.Error as error:
                raise trouble_of(error, path) from error

    @contextmanager
    def transaction(self) -> Iterator[None]:
        """One transaction: durable as a whole when it ends, or not at all. Other threads wait meanwhile. A nested one
        belongs to the outer one."""
        with self._lock:
            if self._together_in is not None:
                yield
                return
            self._execute("BEGIN IMMEDIATE")
            if self._is_moved():
                self._come_back()
                self._execute("BEGIN IMMEDIATE")
            self._together_in = threading.get_ident()
            try:
                yield
                self._execute("COMMIT")
            except BaseException:
                with suppress(sqlite3.Error):  # a full disk has already rolled it back
                    self._connection.execute("ROLLBACK")
                raise
            finally:
                self._together_in = None

    def _execute(self, statement: str, values: Sequence[Any] = ()) -> sqlite3.Cursor:
        try:
            return self._connection.execute(statement, values)
        except sqlite3.Error as error:
            raise self._trouble(error) from error

    def _trouble(self, error: Exception) -> StoreTrouble:
        return self._end or trouble_of(error, self.path)  # type: ignore[arg-type]

    def _is_moved(self) -> bool:
        try:
            return self._places not in (None, places(self.path))
        except OSError:
            return False  # what cannot be looked at is not known to be gone

    def _come_back(self) -> None:
        """See `app.store.moved`. Within a transaction, which it ends."""
        _log.warning("%s was removed, moved or replaced while it was open", self.path)
        old = (self._connection, self._reading)
        try:
            with self._reading_lock:
                put_back(Opened(self.path, self._places or (), *old), self._clock)
                self._open()
        except (sqlite3.Error, OSError, MovedOn) as error:
            if isinstance(error, MovedOn):
                _disconnect(*old)
                self._places, self._end = None, StoreTrouble(StoreFault.FAILED, error.aside, str(error))
            raise self._trouble(error) from error
        finally:
            with suppress(sqlite3.Error):
                old[0].execute("ROLLBACK")
        _disconnect(*old)

    def keep_in_place(self) -> None:
        """For a program that notes nothing for long. See `app.store.moved`; never raises."""
        if self._is_moved():
            with suppress(StoreTrouble), self.transaction():
                pass

    def copy_if_due(self) -> None:
        """See `app.store.copies`. Returns at once."""
        if self._copies is not None:
            self._copies.start_if_due()

    def close(self) -> None:
        """Idempotent, never raises."""
        if self._copies is not None:
            self._copies.stop()
        self.keep_in_place()
        with self._lock, self._reading_lock:
            _disconnect(self._reading, self._connection)
            self._places = None


def _disconnect(*connections: sqlite3.Connection) -> None:
    for connection in connections:
        with suppress(sqlite3.Error):
            connection.close()


def open_database(folder: Path, layout: StoreLayout, *, clock: Clock = utc_now, name: str = FILE_NAME) -> Database:
    """Raises `StoreTrouble` if it cannot be used. Only the store itself, not the archive, is copied."""
    path = folder / name
    try:
        folder.mkdir(parents=True, exist_ok=True)
        try:
            if not _has_content(path) and (copy := restore(path, clock())) is not None:
                return _open(path, clock, layout, _kept_aside(copy))
            return _open(path, clock, layout)
        except sqlite3.OperationalError:
            raise  # a lock, a full disk or a missing permission: the file itself is not bad
        except sqlite3.DatabaseError:
            kept = message(ASIDE, file=set_aside(path, clock))
            return _open(path, clock, layout, _kept_aside(restore(path, clock()), kept))
    except (sqlite3.Error, OSError) as error:
        raise trouble_of(error, path) from error


def _has_content(path: Path) -> bool:
    """In the file or in its write-ahead log."""
    return any(file.exists() and file.stat().st_size for file in companions(path)[:2])


def _kept_aside(copy: Path | None, *before: UserMessage) -> UserMessage:
    """What became of the records. `copy`: which took the file's place, None where there was none."""
    at = copied_at(copy) if copy is not None else None
    if at is None:
        return joined((*before, message(marked("New records are started."))), " ")
    text = marked("Records restored from the copy of {when}; later ones are missing.")
    return joined((*before, message(text, when=f"{at.astimezone():%Y-%m-%d %H:%M}")), " ")


def _open(path: Path, clock: Clock, layout: StoreLayout, notice: UserMessage | None = None) -> Database:
    had_content = path.exists() and path.stat().st_size > 0
    if had_content:
        with path.open("rb") as file:
            if file.read(len(_MAGIC)) != _MAGIC:  # SQLite would remove its write-ahead log
                raise sqlite3.DatabaseError("no database")
    copies = Copier(path.absolute(), clock) if path.name == FILE_NAME else None
    database = Database(path, layout, clock, copies=copies, notice=notice)
    if had_content and copies is not None:
        copies.start_if_due(AT_OPENING_S)
    return database


def _connect_both(path: Path, layout: StoreLayout) -> tuple[sqlite3.Connection, sqlite3.Connection]:
    connection = _connect(path)
    try:
        check(connection)
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        _migrate(connection, path, layout)
        reading = _connect(path)
        reading.execute("SELECT 1 FROM sqlite_schema").fetchone()  # opens the log, which may be removed one day
        return connection, reading
    except BaseException:
        connection.close()
        raise


def _connect(path: Path) -> sqlite3.Connection:
    return sqlite3.connect(path, timeout=BUSY_S, isolation_level=None, check_same_thread=False)


def _migrate(connection: sqlite3.Connection, path: Path, layout: StoreLayout) -> None:
    version = _version(connection)
    if version > layout.version:
        raise StoreTrouble(StoreFault.NEWER, path, f"version {version}")
    if version == layout.version:
        return
    if version:
        _save_copy(connection, path, version)
    connection.execute("BEGIN IMMEDIATE")
    try:
        version = _version(connection)  # another window may have migrated while this one waited for the lock
        if version < layout.version:
            (layout.convert if version else make_tables)(connection)
        connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
        connection.execute(f"PRAGMA user_version = {layout.version}")
        connection.execute("COMMIT")
    except BaseException as error:
        with suppress(sqlite3.Error):
            connection.execute("ROLLBACK")
        if isinstance(error, (sqlite3.IntegrityError, sqlite3.ProgrammingError, ValueError, TypeError, LookupError)):
            raise StoreTrouble(StoreFault.FAILED, path, repr(error)) from error  # the file is not damaged
        raise


def _version(connection: sqlite3.Connection) -> int:
    return int(connection.execute("PRAGMA user_version").fetchone()[0])


def _save_copy(connection: sqlite3.Connection, path: Path, version: int) -> None:
    """The file as it was, whole or not at all. One that is there already is older and stays."""
    kept = path.with_name(f"{path.stem}.version-{version}{path.suffix}")
    if kept.exists():
        return
    with draft_of(kept) as draft, closing(sqlite3.connect(draft)) as copy:
        connection.backup(copy)
