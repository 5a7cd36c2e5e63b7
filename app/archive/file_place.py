"""An SQLite file that somebody brings, as a place where facts are exchanged."""

import hashlib
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from app.store.fact_store import INSERT
from app.store.opening import APPLICATION_ID, BUSY_S, make_tables
from app.store.rows import COLUMNS, Row
from app.system.files import CANNOT_READ
from app.text.user_error import ErrorCode, UserError

# Digits of an id: 2**28 ms, about three days.
BUCKET = 5
# Bytes. A row that is larger refuses the file.
LARGEST_ROW = 64_000_000
_IS_ID = "length(id) = 40 AND id NOT GLOB '*[^0-9a-f]*'"

# By the first digits of ids: how many there are, and a digest of them.
Buckets = Mapping[str, tuple[int, str]]


def digests(connection: sqlite3.Connection, *tables: str, where: str = "TRUE") -> Buckets:
    """Of the ids in these tables together; the same that a server makes (md5: to compare, not to protect). SQLite puts
    the ids of each part together, as a loop over 600,000 of them takes seconds."""
    parts = [f"SELECT DISTINCT substr(id, 1, {BUCKET}) FROM {table} WHERE {where}" for table in tables]  # noqa: S608
    ids = " UNION ".join(f"SELECT id FROM {table} WHERE id >= ?1 AND id < ?2 AND {where}" for table in tables)  # noqa: S608
    query = f"SELECT count(*), group_concat(id, '') FROM ({ids} ORDER BY id)"  # noqa: S608
    found = {}
    for (bucket,) in connection.execute(" UNION ".join(parts)).fetchall():
        count, together = connection.execute(query, (bucket, f"{bucket}g")).fetchone()
        found[bucket] = (count, hashlib.md5(together.encode(), usedforsecurity=False).hexdigest())
    return found


def lengths_in(connection: sqlite3.Connection, bucket: str) -> dict[str, int]:
    query = f"SELECT id, length(CAST(content AS BLOB)) FROM facts WHERE id >= ? AND id < ? AND {_IS_ID}"  # noqa: S608
    return dict(connection.execute(query, (bucket, f"{bucket}g")).fetchall())


def rows_in(connection: sqlite3.Connection, ids: list[str]) -> list[tuple[Any, ...]]:
    places = ", ".join("?" * len(ids))
    return connection.execute(f"SELECT {COLUMNS} FROM facts WHERE id IN ({places})", ids).fetchall()  # noqa: S608


class FileTrouble(UserError):
    """The file is no archive file, damaged, or cannot be written."""

    code = ErrorCode.UNREADABLE


class FilePlace:
    """Nothing in the file is believed, not even that `facts` is a table. It is made where it is missing. Every method
    raises `UserError`. `name`: as a person reads it."""

    def __init__(self, path: Path) -> None:
        self.name = str(path)
        with self._troubles():
            self._connection = sqlite3.connect(path, timeout=BUSY_S, isolation_level=None, check_same_thread=False)
            try:
                _prepare(self._connection)
            except BaseException:
                self.close()
                raise

    def close(self) -> None:
        self._connection.close()

    def buckets(self) -> Buckets:
        with self._troubles():
            return digests(self._connection, "facts", where=_IS_ID)

    def lengths(self, bucket: str) -> dict[str, int]:
        """Bytes of the content, by id."""
        with self._troubles():
            return lengths_in(self._connection, bucket)

    def rows(self, ids: list[str]) -> list[tuple[Any, ...]]:
        """As they stand there."""
        with self._troubles():
            return rows_in(self._connection, ids)

    def add(self, rows: list[Row]) -> int:
        """How many were new: they are durable."""
        before = self._connection.total_changes
        with self._troubles(), self._connection:  # which commits, or rolls back where it fails
            self._connection.execute("BEGIN IMMEDIATE")
            self._connection.executemany(INSERT, rows)
        return self._connection.total_changes - before

    @contextmanager
    def _troubles(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            raise FileTrouble(CANNOT_READ, file=self.name, why=str(error)) from error


def _prepare(connection: sqlite3.Connection) -> None:
    """Raises `sqlite3.Error` for what is no archive file."""
    connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_ROW)
    # A stranger's text may be no UTF-8: it cannot be encoded again, and so is no fact.
    connection.text_factory = lambda data: data.decode(errors="surrogateescape")
    connection.execute("PRAGMA trusted_schema = OFF")
    connection.execute("PRAGMA cell_size_check = ON")
    # No write-ahead log: a stick that is pulled out has one file, and not two of three.
    connection.execute("PRAGMA journal_mode = DELETE")
    connection.execute("PRAGMA synchronous = FULL")
    if not _schema_of(connection):
        make_tables(connection)
    if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
        raise sqlite3.DatabaseError("no archive file")
    # A trigger or a view of somebody else's would run when the file is read or written.
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as ours:
        make_tables(ours)
        if _schema_of(connection) != _schema_of(ours):
            raise sqlite3.DatabaseError("its tables are not those of an archive file")
    if connection.execute("PRAGMA quick_check(1)").fetchone()[0] != "ok":
        raise sqlite3.DatabaseError("damaged")


def _schema_of(connection: sqlite3.Connection) -> list[tuple[str, str, str]]:
    return connection.execute("SELECT type, name, sql FROM sqlite_master ORDER BY type, name").fetchall()
