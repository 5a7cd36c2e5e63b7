"""Where facts are exchanged: an SQLite file that somebody brings, or a server (`app.archive.postgres`).

Two sides find out what the other lacks by their ids, whose first five digits name three days: see `app.archive.sync`.
"""

import hashlib
import sqlite3
from collections.abc import Iterable, Mapping
from contextlib import closing
from itertools import groupby
from pathlib import Path
from typing import Any, Protocol

from app.store.fact_store import INSERT
from app.store.opening import APPLICATION_ID, make_tables
from app.store.rows import COLUMNS, Row
from app.system.files import CANNOT_READ
from app.text.user_error import ErrorCode, UserError

BUCKET = 5
"""Digits of an id: 2**28 ms, about three days."""
LARGEST_ROW = 64_000_000
"""Bytes. A row that is larger refuses the file."""
BUSY_S = 5.0
_IS_ID = "length(id) = 40 AND id NOT GLOB '*[^0-9a-f]*'"

Buckets = Mapping[str, tuple[int, str]]
"""By the first digits: the number of ids, and a digest of them."""


class Place(Protocol):
    """Every method raises `UserError`. `name`: as a person reads it, without a password."""

    name: str

    def buckets(self) -> Buckets: ...

    def lengths(self, bucket: str) -> dict[str, int]:
        """Bytes of the content, by id."""
        ...

    def rows(self, ids: list[str]) -> list[tuple[Any, ...]]:
        """As they stand there: nothing in them is to be believed."""
        ...

    def add(self, rows: list[Row]) -> int:
        """How many were new. Durable on return."""
        ...

    def close(self) -> None: ...


def digest_of(ids: str) -> str:
    """Of ids in their order, one behind the other; as a server makes it (md5: to compare, not to protect)."""
    return hashlib.md5(ids.encode(), usedforsecurity=False).hexdigest()


def digests(ids: Iterable[str]) -> dict[str, tuple[int, str]]:
    """Of ids in their order."""
    found = {}
    for bucket, group in groupby(ids, key=lambda id_: id_[:BUCKET]):
        together = list(group)
        found[bucket] = (len(together), digest_of("".join(together)))
    return found


def lengths_in(connection: sqlite3.Connection, table: str, bucket: str) -> dict[str, int]:
    query = f"SELECT id, length(CAST(content AS BLOB)) FROM {table} WHERE id >= ? AND id < ? AND {_IS_ID}"  # noqa: S608
    return dict(connection.execute(query, (bucket, f"{bucket}g")).fetchall())


def rows_in(connection: sqlite3.Connection, table: str, ids: list[str]) -> list[tuple[Any, ...]]:
    places = ", ".join("?" * len(ids))
    return connection.execute(f"SELECT {COLUMNS} FROM {table} WHERE id IN ({places})", ids).fetchall()  # noqa: S608


class FileTrouble(UserError):
    """The file is no archive file, damaged, or cannot be written."""

    code = ErrorCode.UNREADABLE


class FilePlace:
    """Nothing in the file is believed, not even that `facts` is a table. It is made where it is missing."""

    def __init__(self, path: Path) -> None:
        self.name = str(path)
        self._path = path
        try:
            self._connection = sqlite3.connect(path, timeout=BUSY_S, isolation_level=None, check_same_thread=False)
            try:
                self._open()
            except BaseException:
                self._connection.close()
                raise
        except sqlite3.Error as error:
            raise self._trouble(error) from error

    def close(self) -> None:
        self._connection.close()

    def buckets(self) -> Buckets:
        try:
            found = self._connection.execute(f"SELECT id FROM facts WHERE {_IS_ID} ORDER BY id")  # noqa: S608
            return digests(id_ for (id_,) in found)
        except sqlite3.Error as error:
            raise self._trouble(error) from error

    def lengths(self, bucket: str) -> dict[str, int]:
        try:
            return lengths_in(self._connection, "facts", bucket)
        except sqlite3.Error as error:
            raise self._trouble(error) from error

    def rows(self, ids: list[str]) -> list[tuple[Any, ...]]:
        self._connection.text_factory = bytes  # a stranger's text may be no UTF-8
        try:
            return [tuple(map(_text, row)) for row in rows_in(self._connection, "facts", ids)]
        except sqlite3.Error as error:
            raise self._trouble(error) from error
        finally:
            self._connection.text_factory = str

    def add(self, rows: list[Row]) -> int:
        before = self._connection.total_changes
        try:
            self._connection.execute("BEGIN IMMEDIATE")
            self._connection.executemany(INSERT, rows)
            self._connection.execute("COMMIT")
        except sqlite3.Error as error:
            if self._connection.in_transaction:
                self._connection.execute("ROLLBACK")
            raise self._trouble(error) from error
        return self._connection.total_changes - before

    def _open(self) -> None:
        connection = self._connection
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_ROW)
        connection.execute("PRAGMA trusted_schema = OFF")
        connection.execute("PRAGMA cell_size_check = ON")
        # No write-ahead log: a stick that is pulled out has one file, and not two of three.
        connection.execute("PRAGMA journal_mode = DELETE")
        connection.execute("PRAGMA synchronous = FULL")
        if not connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
            make_tables(connection)
        if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
            raise sqlite3.DatabaseError("no archive file")
        if _schema_of(connection) != _own_schema():
            raise sqlite3.DatabaseError("its tables are not those of an archive file")
        if connection.execute("PRAGMA quick_check(1)").fetchone()[0] != "ok":
            raise sqlite3.DatabaseError("damaged")

    def _trouble(self, error: sqlite3.Error) -> UserError:
        return FileTrouble(CANNOT_READ, file=self._path, why=str(error))


def _schema_of(connection: sqlite3.Connection) -> list[tuple[str, str, str]]:
    return connection.execute("SELECT type, name, sql FROM sqlite_master ORDER BY type, name").fetchall()


def _own_schema() -> list[tuple[str, str, str]]:
    """A trigger or a view of somebody else's would run when the file is read or written."""
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as connection:
        make_tables(connection)
        return _schema_of(connection)


def _text(value: object) -> object:
    """What is no UTF-8 becomes None, and so is no fact."""
    try:
        return value.decode() if isinstance(value, bytes) else value
    except UnicodeDecodeError:
        return None
