"""The facts and the state of this station, in one SQLite file with one writer.

    add, write, set_state   return a future at once; the store's thread does the work, in the order of the calls
    read, state             in the thread of whoever asks, over a connection of their own

The file is opened and checked in the store's thread, too, so that no port and no window waits for the disk. Every
write is on the disk when its future is done (WAL, `synchronous=FULL`).
"""

import logging
import platform
import queue
import sqlite3
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import closing, suppress
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

import msgspec

from app.store.opening import (
    FILE_NAME,
    StoreFault,
    StoreTrouble,
    connect_to_read,
    copy_if_due,
    former_state,
    open_file,
    trouble_of,
)
from app.store.rows import (
    AHEAD,
    COLUMNS,
    KIND_OF,
    Content,
    Row,
    StationNamed,
    content_of,
    content_text,
    make_row,
    time_text,
)
from app.store.station import own_station
from app.system.files import data_folder
from app.text.messages import UserError, UserMessage, clean

_log = logging.getLogger(__name__)
Result = TypeVar("Result")
OneContent = TypeVar("OneContent", bound=Content)
Clock = Callable[[], datetime]

# For what is still to be written at `close`.
CLOSE_LIMIT_S = 5.0
# For the copy of the day that is still being made then; else it is made at the next opening.
COPY_LIMIT_S = 0.3
# Twice the same fact is one: a restored copy gets it again from the archive.
INSERT = f"INSERT INTO facts ({COLUMNS}) VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING"  # noqa: S608
_SET_STATE = "INSERT INTO state VALUES (?, ?) ON CONFLICT (key) DO UPDATE SET value = excluded.value"
_OWN_KEY = "station"


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
    """What a piece of work reads from and writes to: one connection, and within `Store.write` one transaction."""

    def __init__(self, connection: sqlite3.Connection, station: str, make_time: Callable[[], datetime]) -> None:
        self.connection = connection
        self.station = station
        self._make_time = make_time

    def now(self) -> datetime:
        """Later than any time before."""
        return self._make_time()

    def add(self, content: Content, module: str | None = None, *, at: datetime | None = None) -> Row:
        """Only within `Store.write`. `at`: else now. Raises `ValueError` for a content that is none."""
        at = at or self._make_time()
        row = make_row(KIND_OF[type(content)], content_text(content), module=module, station=self.station, at=at)
        self.connection.execute(INSERT, row)
        return row

    def of_module(self, type_: type[OneContent], module: str | None) -> list[Kept[OneContent]]:
        """The facts of this kind about this module (None: about modules without a name), the oldest first."""
        return list(self._each(type_, "module IS ?", module, order="ASC"))

    def of_kind(self, type_: type[OneContent]) -> list[Kept[OneContent]]:
        """Those about all modules, the oldest first."""
        return list(self._each(type_, "TRUE", order="ASC"))

    def back_from_newest(self, type_: type[OneContent], *module: str | None) -> Iterator[Kept[OneContent]]:
        """Those of a module, or where none is given of all; each is read when it is asked for."""
        return self._each(type_, "module IS ?" if module else "TRUE", *module, order="DESC")

    def newest(self, type_: type[OneContent], module: str | None) -> Kept[OneContent] | None:
        return next(self.back_from_newest(type_, module), None)

    def by_id(self, type_: type[OneContent], id_: str) -> Kept[OneContent] | None:
        return next(self._each(type_, "id = ?", id_, order="ASC"), None)

    def modules(self) -> list[str]:
        """The names of all modules that a fact is about."""
        rows = self.connection.execute("SELECT DISTINCT module FROM facts WHERE module IS NOT NULL ORDER BY module")
        return [name for (name,) in rows]

    def state(self, key: str) -> Any:
        """None where it is not set, or cannot be read."""
        rows = self.connection.execute("SELECT value FROM state WHERE key = ?", (key,)).fetchall()
        return _decoded(key, rows[0][0]) if rows else None

    def states(self, prefix: str) -> dict[str, Any]:
        """By the rest of their keys, without those that cannot be read."""
        query = "SELECT key, value FROM state WHERE substr(key, 1, ?) = ? ORDER BY key"
        rows = self.connection.execute(query, (len(prefix), prefix))
        decoded = {key.removeprefix(prefix): _decoded(key, value) for key, value in rows}
        return {rest: value for rest, value in decoded.items() if value is not None}

    def set_state(self, key: str, value: object) -> None:
        """None removes it. Only within `Store.write`."""
        if value is None:
            self.connection.execute("DELETE FROM state WHERE key = ?", (key,))
        else:
            self.connection.execute(_SET_STATE, (key, msgspec.json.encode(value).decode()))

    def _each(self, type_: type[OneContent], where: str, *values: str | None, order: str) -> Iterator[Kept[OneContent]]:
        """Without those that cannot be read, as of a newer version, and those from a clock that is ahead."""
        query = f"SELECT {COLUMNS} FROM facts WHERE kind = ? AND {where} AND made_at <= ? ORDER BY made_at {order}"  # noqa: S608
        latest = time_text(utc_now() + AHEAD)
        for found in self.connection.execute(query, (KIND_OF[type_], *values, latest)):
            row = Row(*found)
            content = content_of(row, type_)
            if content is not None:
                yield Kept(row, content)


class Store:
    """Made at once. Any thread may call. Its thread is a daemon, so a disk that never answers does not keep the program
    from ending."""

    def __init__(self, folder: Path | None = None, *, clock: Clock = utc_now, starts_late: bool = False) -> None:
        """`starts_late`: it opens only when it is first used, so that nothing competes with LOCK's first frame."""
        self.folder = (folder or data_folder()).absolute()
        self.path = self.folder / FILE_NAME
        # Done when the file is open, with what a person should know; or has the reason why it is not.
        self.opened: Future[UserMessage | None] = Future()
        self._station = ""
        self._clock = clock
        self._last_time = datetime.min.replace(tzinfo=UTC)
        self._lock = threading.Lock()
        self._work: queue.SimpleQueue[tuple[Callable[[Facts], Any], Future[Any]] | None] = queue.SimpleQueue()
        self._is_closed = False
        self._copying: threading.Thread | None = None
        self._thread: threading.Thread | None = None
        if not starts_late:
            self.start()

    def start(self) -> None:
        """Begin to open it, where that has not begun. Returns at once."""
        with self._lock:
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="dps-s store", daemon=True)
                self._thread.start()

    @property
    def station(self) -> str:
        """The public key of this station, as hex. Waits for the opening. Raises `StoreTrouble`."""
        self.opened.result()
        return self._station

    def add(self, content: Content, module: str | None = None) -> "Future[Row]":
        """The row, once it is on the disk. A content that is none raises `ValueError` here, in the caller."""
        content_text(content)
        at = self._make_time()
        return self.write(lambda facts: facts.add(content, module, at=at))

    def set_state(self, key: str, value: object) -> "Future[None]":
        """None removes it."""
        return self.write(lambda facts: facts.set_state(key, value))

    def write(self, work: Callable[[Facts], Result]) -> "Future[Result]":
        """`work` is one transaction, in the store's thread. Its future has the result once that is on the disk; it
        raises `StoreTrouble`, or what `work` raises. A future that is cancelled in time is never written."""
        future: Future[Result] = Future()
        self.start()
        with self._lock:
            if self._is_closed:
                future.cancel()
                return future
            self._work.put((work, future))
        return future

    def read(self, work: Callable[[Facts], Result]) -> Result:
        """In this thread. Waits for the opening, so not in the window's before that. Raises `StoreTrouble`."""
        self.start()
        station = self.station
        try:
            with closing(connect_to_read(self.path)) as connection:
                return work(Facts(connection, station, self._make_time))
        except sqlite3.Error as error:
            raise trouble_of(error, self.path) from error

    def state(self, key: str) -> Any:
        """None where it is not set. Raises `StoreTrouble`."""
        return self.read(lambda facts: facts.state(key))

    def copy_if_due(self) -> None:
        """Returns at once: the day's copy is made in a thread of its own."""
        if self.opened.done() and self.opened.exception() is None:
            copy = partial(copy_if_due, self.path, self._clock())
            self._copying = threading.Thread(target=copy, name="dps-s copies", daemon=True)
            self._copying.start()

    def close(self, limit_s: float = CLOSE_LIMIT_S) -> bool:
        """Write what is left; returns whether all of it was written within the limit. Idempotent, never raises."""
        with self._lock:
            if not self._is_closed:
                self._is_closed = True
                self._work.put(None)
        if self._thread is None:
            return True
        self._thread.join(limit_s)
        if self._copying is not None:
            self._copying.join(COPY_LIMIT_S)
        if self._thread.is_alive():
            _log.warning("The store was closed before everything was written")
        return not self._thread.is_alive()

    def _make_time(self) -> datetime:
        with self._lock:
            self._last_time = max(self._clock(), self._last_time + timedelta(microseconds=1))
            return self._last_time

    # The store's thread

    def _run(self) -> None:
        connection: sqlite3.Connection | None = None
        try:
            connection, notice = self._open()
        except BaseException as error:  # noqa: BLE001  also a fault of the program: nobody may wait for ever
            _log.warning("There is no store: %s", error)
            if isinstance(error, sqlite3.Error | OSError):
                error = trouble_of(error, self.path)
            self.opened.set_exception(error)
        else:
            self.opened.set_result(notice)
            self.copy_if_due()
        while (item := self._work.get()) is not None:
            self._do(connection, *item)
        if connection is not None:
            connection.close()

    def _open(self) -> tuple[sqlite3.Connection, UserMessage | None]:
        """Raises as `open_file`."""
        connection, notice, former = open_file(self.path)
        try:
            facts = Facts(connection, "", self._make_time)
            facts.station = self._station = self._own_key(facts)
            _introduce(facts)
            for key, value in ({} if former is None else former_state(former)).items():
                facts.set_state(key, value)
        except BaseException:
            connection.close()
            raise
        return connection, notice

    def _own_key(self, facts: Facts) -> str:
        """Where the key's file cannot be read any more, facts go on under the key of before; only signing needs it."""
        known = facts.state(_OWN_KEY)
        try:
            key = own_station(self.folder).public.hex()
        except UserError as error:
            _log.warning("The key of this station cannot be used: %s", error)
            if not isinstance(known, str):
                raise StoreTrouble(StoreFault.FAILED, self.path, str(error)) from error
            return known
        if known != key:
            facts.set_state(_OWN_KEY, key)
        return key

    def _do(self, connection: sqlite3.Connection | None, work: Callable[[Facts], Any], future: "Future[Any]") -> None:
        if future.set_running_or_notify_cancel():
            try:
                future.set_result(self._transact(connection, work))
            except BaseException as error:  # noqa: BLE001  passed on by the future as what it is
                if not isinstance(error, UserError):
                    _log.error("A fault of the program, and none of the store", exc_info=error)
                future.set_exception(error)

    def _transact(self, connection: sqlite3.Connection | None, work: Callable[[Facts], Result]) -> Result:
        """Raises `StoreTrouble`, or what `work` raises."""
        if connection is None:
            self.opened.result()  # raises why there is none
            raise AssertionError
        try:
            # IMMEDIATE waits for other programs here, and not in the middle of the work.
            connection.execute("BEGIN IMMEDIATE")
            result = work(Facts(connection, self._station, self._make_time))
            connection.execute("COMMIT")
        except BaseException as error:
            with suppress(sqlite3.Error):  # a full disk has already rolled it back
                connection.execute("ROLLBACK")
            if isinstance(error, sqlite3.Error):
                raise trouble_of(error, self.path) from error
            raise
        return result


def _decoded(key: str, value: str) -> Any:
    """None where it is damaged, which costs neither the store nor the other states."""
    try:
        return msgspec.json.decode(value)
    except msgspec.DecodeError as error:
        _log.warning("The state “%s” cannot be read: %s", key, error)
        return None


def _introduce(facts: Facts) -> None:
    """This station by its key and the name of its computer, where it is not known by that yet."""
    name = clean(platform.node().strip()) or "station"
    known = facts.newest(StationNamed, None)
    if known is None or (known.content.public_key, known.content.name) != (facts.station, name):
        facts.add(StationNamed(public_key=facts.station, name=name))
