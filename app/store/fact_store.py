"""The facts and the state of this station, in one SQLite file with one writer.

    write, set_state        return a future at once; the store's thread does the work, in the order of the calls
    read, state             in the thread of whoever asks, over a connection of their own

The file is opened and checked in the store's thread, too, so that no port and no window waits for the disk. Every
write is on the disk when its future is done (WAL, `synchronous=FULL`). A file that cannot be read is never overwritten:

not there, empty     made; from the newest good copy, where there is one
damaged, another's, of a development build   set aside under another name, and as above; what it leaves ACTIVE stays
a newer version's, held, not writable    left alone: `StoreError`
"""

import logging
import os
import platform
import queue
import shutil
import sqlite3
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from contextlib import closing, suppress
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

import msgspec

from app.safety.left_active import LEFT, LeftActive
from app.store.rows import AHEAD, COLUMNS, KIND_OF, Content, OneContent, Row, StationNamed, row_of, time_text
from app.store.station import own_station
from app.system.files import data_folder
from app.text.messages import ErrorCode, UserError, UserMessage, clean, error_text, joined, message
from protocol.translatable import marked

_log = logging.getLogger(__name__)
Result = TypeVar("Result")
Clock = Callable[[], datetime]

FILE_NAME = "dps-s.sqlite"
# "DPSS": how our file is told from another program's.
APPLICATION_ID = 0x44505353
LAYOUT = 20
# How long another program may hold the file before a call fails.
BUSY_S = 5.0
COPIES_KEPT = 7
_KEPT = "BEGIN SELECT RAISE(ABORT, 'facts are only ever added'); END"
TABLES = (
    """
    CREATE TABLE facts (
        id TEXT PRIMARY KEY,
        kind TEXT NOT NULL,
        module TEXT,
        station TEXT NOT NULL,
        made_at TEXT NOT NULL,
        content TEXT NOT NULL
    ) STRICT
    """,
    "CREATE INDEX facts_of_module ON facts (module, kind, made_at)",
    "CREATE INDEX facts_of_kind ON facts (kind, made_at)",
    f"CREATE TRIGGER facts_not_changed BEFORE UPDATE ON facts {_KEPT}",
    f"CREATE TRIGGER facts_not_removed BEFORE DELETE ON facts {_KEPT}",
    "CREATE TABLE state (key TEXT PRIMARY KEY, value TEXT NOT NULL) STRICT",
)
# For what a command or a check waits for, and for what is still to be written at `close`, as a disk may never answer;
# longer than `BUSY_S`, so that it is told if another program holds the file.
ANSWER_LIMIT_S = 6.0
# How often it is looked whether the copy of the day was made, in a program that is open for days.
COPY_EVERY_S = 600.0
# For the copy that is still being made at `close`; else it is made at the next opening.
COPY_LIMIT_S = 0.3
# With less room on the disk there is none for a commit.
MIN_FREE_BYTES = 64 * 1024
FULL = marked("the disk is full")
OPENING = marked("it is still being opened")
# Twice the same fact is one: a restored copy gets it again from the archive.
INSERT = f"INSERT INTO facts ({COLUMNS}) VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING"  # noqa: S608


class StoreError(UserError):
    """The store cannot be opened, read or written. What was stored before is kept."""

    code = ErrorCode.STORE


def unusable(path: Path, why: str | Exception) -> StoreError:
    """`why`: `marked`, or in the system's words."""
    text = why if isinstance(why, str) else error_text(why)
    if isinstance(why, sqlite3.Error):
        with suppress(OSError):  # of a full disk SQLite says this and that
            text = FULL if shutil.disk_usage(path.parent).free < MIN_FREE_BYTES else text
    return StoreError(marked("{file} cannot be used: {why}."), file=path, why=UserMessage(text))


# The file


def open_file(path: Path) -> tuple[sqlite3.Connection, UserMessage | None]:
    """The file, and what a person should know. Raises `sqlite3.Error`, `OSError` or `StoreError`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with suppress(OSError):
        path.parent.chmod(0o700)  # what is in it is for this user only
    was_there = path.exists() and path.stat().st_size > 0
    if was_there or not copies_of(path):
        try:
            return connect(path, is_checked=True), None
        except sqlite3.OperationalError:
            raise  # a lock, a full disk or a missing permission: the file itself is not bad
        except sqlite3.DatabaseError as error:
            _log.warning("%s: %s", path, error)
    aside = set_aside(path)
    told = [message(marked("The records cannot be used and are kept as {file}."), file=aside)] if was_there else []
    copy = next(filter(is_whole, copies_of(path)), None)
    if copy is not None:
        shutil.copyfile(copy, path)
        text = marked("Records restored from the copy of {when}; later ones are missing.")
        told.append(message(text, when=copy.name.split(".")[1]))
    else:
        told.append(message(marked("New records are started.")))
    connection = connect(path)
    for key, value in _left_active(aside).items():
        connection.execute("INSERT OR REPLACE INTO state VALUES (?, ?)", (key, value))
    return connection, joined(told, " ")


def set_aside(path: Path) -> Path:
    """Give the file another name, with its log and its index: what comes in its place must not meet an old log."""
    aside = path.with_name(f"{path.stem}.aside-{datetime.now(UTC):%Y%m%d-%H%M%S-%f}{path.suffix}")
    for end in ("", "-wal", "-shm"):
        with suppress(FileNotFoundError):
            Path(f"{path}{end}").replace(f"{aside}{end}")
    return aside


def connect(path: Path, *, is_checked: bool = False) -> sqlite3.Connection:
    """The file; made where it is missing. `is_checked`: as a whole. Raises as `open_file`."""
    # As an address, so that a file may be attached as one that is only read.
    address = path.absolute().as_uri()
    connection = sqlite3.connect(address, uri=True, timeout=BUSY_S, isolation_level=None, check_same_thread=False)
    try:
        check_or_make(connection, path)
        if is_checked:
            check_whole(connection)
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute("PRAGMA recursive_triggers = ON")  # else INSERT OR REPLACE removes a row in silence
    except BaseException:
        connection.close()
        raise
    return connection


def connect_to_read(path: Path) -> sqlite3.Connection:
    return sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True, timeout=BUSY_S)


def make_tables(connection: sqlite3.Connection) -> None:
    """Make the tables in one transaction. Another program may have made them while this one waited for the lock."""
    with connection:
        connection.execute("BEGIN IMMEDIATE")
        if not connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
            for statement in TABLES:
                connection.execute(statement)
            connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
            connection.execute(f"PRAGMA user_version = {LAYOUT}")


def check_or_make(connection: sqlite3.Connection, path: Path) -> None:
    """Make the tables in an empty file. Raise `sqlite3.DatabaseError` for one of something else, `StoreError` for a
    newer one."""
    if not connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
        make_tables(connection)
    is_ours = connection.execute("PRAGMA application_id").fetchone()[0] == APPLICATION_ID
    layout = connection.execute("PRAGMA user_version").fetchone()[0]
    if is_ours and layout > LAYOUT:
        raise unusable(path, marked("it needs a newer version of this program"))
    if not is_ours or layout < LAYOUT:
        raise sqlite3.DatabaseError("of another program, or of a development build")


def check_whole(connection: sqlite3.Connection) -> None:
    """Raise `sqlite3.DatabaseError` for a file that is damaged. It takes a second for 200 MB."""
    if connection.execute("PRAGMA quick_check(1)").fetchone()[0] != "ok":
        raise sqlite3.DatabaseError("damaged")


def is_whole(path: Path) -> bool:
    """Whether the file is ours, of this layout, and not damaged."""
    try:
        with closing(connect_to_read(path)) as connection:
            check_or_make(connection, path)
            check_whole(connection)
    except (sqlite3.Error, StoreError):
        return False
    return True


def _left_active(former: Path) -> dict[str, str]:
    """Return what a file that was set aside leaves ACTIVE, as rows of the state, as far as it can be read. That of a
    development build had each intent (`act`) and what came of it (`outcome`, linked by the intent's hash) as JSON."""
    query = """
        SELECT a.made_at, a.payload, o.payload FROM facts a LEFT JOIN facts o ON o.kind = 'outcome' AND o.link = a.hash
        WHERE a.kind = 'act' AND a.link IN ('activate', 'lock', 'shutdown') ORDER BY a.number
    """
    leaves_active = ("activate", "confirmed"), ("activate", "unknown"), ("lock", "refused"), ("lock", "unknown")
    left: dict[str, str] = {}
    # Nothing in it is trusted.
    with (
        suppress(sqlite3.Error, ValueError, LookupError, TypeError, AttributeError),
        closing(connect_to_read(former)) as connection,
    ):
        if connection.execute("PRAGMA user_version").fetchone()[0] == LAYOUT:  # it is damaged elsewhere
            for key, value in connection.execute("SELECT key, value FROM state WHERE key LIKE ?", (f"{LEFT}%",)):
                left[str(key)] = str(value)
            return left
        for at, payload, ended in connection.execute(query):
            content = msgspec.json.decode(payload)
            act, port, detail = content["act"], str(content["port"]), content["detail"]
            outcome = "unknown" if ended is None else msgspec.json.decode(ended)["outcome"]
            module, adapter = str(detail.get("module", "")), str(detail.get("adapter", ""))
            # A module without a name is known by its connection.
            key = f"{LEFT}former {module or (detail.get('run'), adapter, port)}"
            if (act, outcome) in leaves_active and not port.startswith("sim://"):
                here = LeftActive(module=module, port=port, adapter=adapter, at=at, is_lock_unconfirmed=act == "lock")
                left[key] = msgspec.json.encode(here).decode()
            elif act != "activate" and outcome == "confirmed" and not detail.get("is_in_doubt"):
                left.pop(key, None)
    return left


def copies_of(path: Path) -> list[Path]:
    """The newest first."""
    return sorted((path.parent / "copies").glob(f"{path.stem}.*{path.suffix}"), reverse=True)


def copy_if_due(path: Path, now: datetime) -> None:
    """Copy the file once a day. A copy that fails is logged."""
    target = path.parent / "copies" / f"{path.stem}.{now.astimezone(UTC):%Y%m%d}{path.suffix}"
    draft = target.with_suffix(".part")
    try:
        with closing(connect_to_read(path)) as source:
            # One that knows only its own station is copied when it is opened again.
            if target.exists() or len(source.execute("SELECT 1 FROM facts LIMIT 2").fetchall()) < 2:
                return
            target.parent.mkdir(exist_ok=True)
            draft.unlink(missing_ok=True)
            source.execute("VACUUM INTO ?", (str(draft),))
        with draft.open("rb+") as file:
            os.fsync(file.fileno())  # VACUUM INTO itself does not wait for the disk
        draft.replace(target)
        for old in copies_of(path)[COPIES_KEPT:]:
            old.unlink(missing_ok=True)
    except (sqlite3.Error, OSError) as error:
        _log.warning("The store could not be copied: %s", error)


# What is in it


def utc_now() -> datetime:
    return datetime.now(UTC)


class Kept(NamedTuple, Generic[OneContent]):
    """A fact and what it says."""

    row: Row
    content: OneContent

    @property
    def at(self) -> str:
        """ISO 8601 in UTC."""
        return self.row.made_at


class Facts:
    """The facts and the state over one connection, within `Store.write` in one transaction."""

    def __init__(self, connection: sqlite3.Connection, station: str, clock: Clock = utc_now) -> None:
        self.connection, self.station, self._clock = connection, station, clock
        self._last_time = datetime.min.replace(tzinfo=UTC)

    def now(self) -> datetime:
        """Return a time that is later than any before."""
        self._last_time = max(self._clock(), self._last_time + timedelta(microseconds=1))
        return self._last_time

    def add(self, content: Content, module: str | None = None, *, at: datetime | None = None) -> Row:
        """Add a fact; only within `Store.write`. `at` is now where it is missing. Raises `ValueError` for a content
        that is none."""
        row = row_of(content, module=module, station=self.station, at=at or self.now())
        self.connection.execute(INSERT, row)
        return row

    def of_module(self, type_: type[OneContent], module: str | None) -> list[Kept[OneContent]]:
        """The facts of this kind about this module (None: about modules without a name), the oldest first."""
        return list(self._each(type_, "module IS ?", module, order="ASC"))

    def of_kind(self, type_: type[OneContent]) -> list[Kept[OneContent]]:
        """Return the facts of this kind about all modules, the oldest first."""
        return list(self._each(type_, "TRUE", order="ASC"))

    def back_from_newest(self, type_: type[OneContent], module: str | None) -> Iterator[Kept[OneContent]]:
        """Go through the facts as of `of_module`, the newest first; each is read when it is asked for."""
        return self._each(type_, "module IS ?", module, order="DESC")

    def newest(self, type_: type[OneContent], module: str | None) -> Kept[OneContent] | None:
        return next(self.back_from_newest(type_, module), None)

    def by_id(self, type_: type[OneContent], id_: str) -> Kept[OneContent] | None:
        return next(self._each(type_, "id = ?", id_, order="ASC"), None)

    def state(self, key: str) -> Any:
        """Return the value; None where it is not set, or cannot be read."""
        return self.states(key).get("")

    def states(self, prefix: str) -> dict[str, Any]:
        """Return the values by the rest of their keys, without those that cannot be read: a damaged one costs no other
        and no verdict."""
        query = "SELECT key, value FROM state WHERE substr(key, 1, ?) = ? ORDER BY key"
        found = {}
        for key, value in self.connection.execute(query, (len(prefix), prefix)):
            with suppress(msgspec.DecodeError):
                found[key.removeprefix(prefix)] = msgspec.json.decode(value)
        return found

    def set_state(self, key: str, value: object) -> None:
        """Set a value, or remove it with None; only within `Store.write`."""
        self.connection.execute("DELETE FROM state WHERE key = ?", (key,))
        if value is not None:
            self.connection.execute("INSERT INTO state VALUES (?, ?)", (key, msgspec.json.encode(value).decode()))

    def _each(self, type_: type[OneContent], where: str, *values: str | None, order: str) -> Iterator[Kept[OneContent]]:
        """Go through the facts, without those that cannot be read, as of a newer version, and those from a clock that
        is ahead."""
        query = f"SELECT {COLUMNS} FROM facts WHERE kind = ? AND {where} AND made_at <= ? ORDER BY made_at {order}"  # noqa: S608
        latest = time_text(utc_now() + AHEAD)
        for found in self.connection.execute(query, (KIND_OF[type_], *values, latest)):
            row = Row(*found)
            try:
                content = msgspec.json.decode(row.content, type=type_)
            except (msgspec.MsgspecError, RecursionError):
                continue
            yield Kept(row, content)


class Store:
    """A store is made at once, and any thread may call it. Its threads are daemons, so a disk that never answers does
    not keep the program from ending."""

    def __init__(self, folder: Path | None = None, *, clock: Clock = utc_now, starts_late: bool = False) -> None:
        """`starts_late`: it opens only when it is first used, so that nothing competes with LOCK's first frame."""
        self.folder = (folder or data_folder()).absolute()
        self.path = self.folder / FILE_NAME
        # Done when the file is open, with what a person should know; or has the reason why it is not.
        self.opened: Future[UserMessage | None] = Future()
        # The public key of this station, as hex, once it is open.
        self.station = ""
        self._clock = clock
        self._lock = threading.Lock()
        self._is_closed = threading.Event()
        # None ends the thread.
        self._work: queue.SimpleQueue[tuple[Callable[[Facts], Any], Future[Any]] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="dps-s store", daemon=True)
        if not starts_late:
            self.start()

    def start(self) -> None:
        """Begin to open it, where that has not begun. Returns at once."""
        with self._lock:
            if self._thread.ident is None:
                self._thread.start()

    def set_state(self, key: str, value: object) -> "Future[None]":
        return self.write(lambda facts: facts.set_state(key, value))

    def write(self, work: Callable[[Facts], Result]) -> "Future[Result]":
        """`work` is one transaction, in the store's thread. Its future has the result once that is on the disk; it
        raises `StoreError`, or what `work` raises. A future that is cancelled in time is never written."""
        future: Future[Result] = Future()
        self.start()
        with self._lock:
            if self._is_closed.is_set():
                future.cancel()
            else:
                self._work.put((work, future))
        return future

    def write_in_time(self, work: Callable[[Facts], Result]) -> Result:
        """Write, and wait for it within a limit, after which it is taken back, unless it is just being written: then it
        may be kept later. Raises `StoreError`."""
        writing = self.write(work)
        try:
            return writing.result(ANSWER_LIMIT_S)
        except (CancelledError, TimeoutError) as error:  # it was closed meanwhile, or the disk does not answer
            writing.cancel()
            raise unusable(self.path, marked("the disk is too slow")) from error

    def wait(self) -> None:
        """Wait until it is open, for a limited time: not in the window's thread. Raises `StoreError`."""
        self.start()
        try:
            self.opened.result(ANSWER_LIMIT_S)
        except TimeoutError:
            raise unusable(self.path, OPENING) from None

    def read(self, work: Callable[[Facts], Result]) -> Result:
        """Read in this thread, and wait for the opening as `wait`. Raises `StoreError`."""
        self.wait()
        try:
            with closing(connect_to_read(self.path)) as connection:
                return work(Facts(connection, self.station, self._clock))
        except sqlite3.Error as error:
            raise unusable(self.path, error) from error

    def state(self, key: str) -> Any:
        """Return the value; None where it is not set. Raises `StoreError`."""
        return self.read(lambda facts: facts.state(key))

    def close(self, limit_s: float = ANSWER_LIMIT_S) -> bool:
        """Write what is left; returns whether all of it was written within the limit. Idempotent, never raises."""
        with self._lock:
            if not self._is_closed.is_set():
                self._is_closed.set()
                self._work.put(None)
        if self._thread.ident is not None:
            self._thread.join(limit_s)
        if self._thread.is_alive():
            _log.warning("The store was closed before everything was written")
        return not self._thread.is_alive()

    def _copy_daily(self) -> None:
        while True:
            copy_if_due(self.path, self._clock())
            if self._is_closed.wait(COPY_EVERY_S):
                return

    # The store's thread

    def _run(self) -> None:
        try:
            facts, notice = self._open()
        except BaseException as error:  # noqa: BLE001  also a fault of the program: nobody may wait for ever
            _log.warning("There is no store: %s", error)
            trouble = unusable(self.path, error) if isinstance(error, sqlite3.Error | OSError) else error
            self.opened.set_exception(trouble)
            for _work, future in iter(self._work.get, None):
                if future.set_running_or_notify_cancel():
                    future.set_exception(trouble)
            return
        self.opened.set_result(notice)
        # In a thread of its own, as an act's intent would wait for a copy.
        copying = threading.Thread(target=self._copy_daily, name="dps-s copies", daemon=True)
        copying.start()
        with closing(facts.connection):
            for work, future in iter(self._work.get, None):
                if future.set_running_or_notify_cancel():
                    self._do(facts, work, future)
        copying.join(COPY_LIMIT_S)

    def _do(self, facts: Facts, work: Callable[[Facts], Any], future: "Future[Any]") -> None:
        try:
            with facts.connection:  # which commits, or rolls back where it fails
                # IMMEDIATE waits for other programs here, and not in the middle of the work.
                facts.connection.execute("BEGIN IMMEDIATE")
                result = work(facts)
        except sqlite3.Error as error:
            future.set_exception(unusable(self.path, error))
        except BaseException as error:  # noqa: BLE001  passed on by the future as what it is
            if not isinstance(error, UserError):
                _log.error("A fault of the program, and none of the store", exc_info=error)
            future.set_exception(error)
        else:
            future.set_result(result)

    def _open(self) -> tuple[Facts, UserMessage | None]:
        """Open the file, and introduce this station by its key and the name of its computer. Raises as `open_file`."""
        connection, notice = open_file(self.path)
        try:
            self.station = own_station(self.folder).key
            facts, name = Facts(connection, self.station, self._clock), clean(platform.node().strip()) or "station"
            named = StationNamed(public_key=self.station, name=name)
            last = facts.newest(StationNamed, None)
            if last is None or last.content != named:
                facts.add(named)
                facts.set_state("station", self.station)  # only a station's own file has a state: see `FilePlace`
        except BaseException as error:
            connection.close()
            if isinstance(error, UserError):  # its key cannot be used
                raise StoreError(error.message) from error
            raise
        return facts, notice
