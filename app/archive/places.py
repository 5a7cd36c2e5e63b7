"""The places where facts are exchanged: a PostgreSQL server, and an SQLite file that somebody brings.

On the server is one table, to which rows are only ever added. Its address:

postgresql://USER@HOST:PORT/DATABASE?sslrootcert=system

It is shown, logged and stored, so it has no password: that comes from libpq's own places (PGPASSFILE, a service file).
psycopg is loaded when a server is used.
"""

import hashlib
import os
import re
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, Final
from urllib.parse import parse_qsl

from app.store.fact_store import BUSY_S, INSERT, check_or_make, check_whole, make_tables
from app.store.rows import COLUMNS
from app.text.messages import ErrorCode, UserError, clean
from protocol.translatable import marked

# Digits of an id: 2**28 ms, about three days.
BUCKET: Final = 5
# By the first digits of ids: how many there are, and a digest of them.
Buckets = Mapping[str, tuple[int, str]]
_URL: Final = re.compile(r"(?i)postgres(?:ql)?://(?P<place>(?:[^@/?#:]*@)?[^@?#]*)(?P<query>(?:\?[^@#]*)?)")
# A lost server is noticed within 30 s.
_PATIENCE: Final = {
    "connect_timeout": "10",
    "keepalives_idle": "10",
    "keepalives_interval": "5",
    "keepalives_count": "3",
    "tcp_user_timeout": "20000",
    "options": "-c statement_timeout=120s",
}
# What an administrator does once; the first statement makes the table.
SQL_FILE: Final = Path(__file__).with_name("server.sql")
_MAY_NOT: Final = marked("This role may not make the table of the archive. As the server's administrator, once:\n{sql}")
# One statement for a page. The columns go as binary arrays: as text they take psycopg seven times as long.
_ADD: Final = f"""
    INSERT INTO dps_s_facts ({COLUMNS})
    SELECT * FROM unnest(%b::text[], %b::text[], %b::text[], %b::text[], %b::text[], %b::text[])
    ON CONFLICT DO NOTHING
"""  # noqa: S608
_IS_ID: Final = "length(id) = 40 AND id NOT GLOB '*[^0-9a-f]*'"
# Bytes. A row that is larger refuses the file.
LARGEST_ROW: Final = 64_000_000


def is_server(address: str) -> bool:
    return address.strip().lower().startswith(("postgresql://", "postgres://"))


def server_url(text: str) -> str:
    """Return the address of a server as it is kept. Raises `UserError`, whose message contains nothing of `text`, for
    one that may contain a password."""
    match = _URL.fullmatch(text.strip()) if len(text) <= 2000 else None
    if match is None or any(re.search("(?i)password|secret|scram", name) for name, _ in parse_qsl(match["query"][1:])):
        sentence = marked("Write {example}. The password belongs into ~/.pgpass or a service file.")
        raise UserError(sentence, example="postgresql://USER@HOST/DATABASE")
    return f"postgresql://{match['place']}{match['query']}"


class ServerTrouble(UserError):
    """The server cannot be reached or used."""

    code = ErrorCode.NO_LINK


class PostgresPlace:
    """Used by one thread. Every method raises `UserError`."""

    def __init__(self, address: str) -> None:
        """Makes the table where it is missing and the role may."""
        self.name = server_url(address)
        try:
            import ssl

            import psycopg
            from psycopg.conninfo import conninfo_to_dict
        except ImportError as error:
            install = 'pip install "dps-s-configurator[archive]"'
            raise ServerTrouble(marked("psycopg is not installed: {command}"), command=install) from error
        # For sslrootcert=system: the OpenSSL that psycopg brings looks for the trusted certificates where none are.
        roots = ssl.get_default_verify_paths()
        for name, place in (("SSL_CERT_FILE", roots.cafile), ("SSL_CERT_DIR", roots.capath)):
            if place is not None:
                os.environ.setdefault(name, place)
        sql = SQL_FILE.read_text(encoding="utf-8")
        with self._troubles():
            options: dict[str, Any] = _PATIENCE | conninfo_to_dict(self.name) | {"client_encoding": "UTF8"}
            self._connection = psycopg.connect(autocommit=True, **options)
            try:
                if self._connection.info.parameter_status("server_encoding") != "UTF8":
                    raise ServerTrouble(marked("The database of the archive has to be made with the encoding UTF8."))
                if self._connection.execute("SELECT to_regclass('dps_s_facts')").fetchone() == (None,):
                    self._connection.execute(sql.partition(";")[0])
            except psycopg.errors.InsufficientPrivilege as error:
                self.close()
                raise ServerTrouble(_MAY_NOT, sql=sql) from error
            except BaseException:
                self.close()
                raise

    def close(self) -> None:
        self._connection.close()

    def buckets(self) -> Buckets:
        digest = "md5(string_agg(id, '' ORDER BY id))"
        query = f"SELECT left(id, {BUCKET}), count(*), {digest} FROM dps_s_facts GROUP BY 1"  # noqa: S608
        return {bucket: (count, found) for bucket, count, found in self._all(query)}

    def lengths(self, bucket: str) -> dict[str, int]:
        # octet_length, unlike length, does not unpack what is stored compressed.
        query = "SELECT id, octet_length(content) FROM dps_s_facts WHERE id >= %s AND id < %s"
        return dict(self._all(query, bucket, f"{bucket}g"))

    def rows(self, ids: list[str]) -> list[tuple[Any, ...]]:
        return self._all(f"SELECT {COLUMNS} FROM dps_s_facts WHERE id = ANY(%s)", ids)  # noqa: S608

    def _all(self, query: str, *values: object) -> list[Any]:
        with self._troubles():
            return self._connection.execute(query, values).fetchall()

    def add(self, rows: list[tuple[Any, ...]]) -> int:
        """Add rows in the order of their ids, so that two stations never wait for each other in a circle."""
        columns = [list(column) for column in zip(*rows, strict=True)]
        with self._troubles():
            return self._connection.execute(_ADD, columns).rowcount

    @contextmanager
    def _troubles(self) -> Iterator[None]:
        import psycopg

        try:
            yield
        except (psycopg.Error, UnicodeError) as error:
            # The reason is at the end of the first line. Behind it is advice, such as to do without TLS, or a row.
            why = str(error).partition("\n")[0].rpartition(" failed: ")[2]
            text = marked("The archive server {server} cannot be used: {why}")
            raise ServerTrouble(text, server=self.name, why=clean(why, longest=300)) from None


# A file that somebody brings, as a place where facts are exchanged


def digests(connection: sqlite3.Connection, table: str, where: str = "TRUE") -> Buckets:
    """Return a digest of the ids in this table, for each part; the same that a server makes (md5: to compare, not to
    protect). SQLite puts the ids of each part together, as a loop over 600,000 of them takes seconds."""
    parts = f"SELECT DISTINCT substr(id, 1, {BUCKET}) FROM {table} WHERE {where}"  # noqa: S608
    ids = f"SELECT DISTINCT id FROM {table} WHERE id >= ?1 AND id < ?2 AND {where} ORDER BY id"  # noqa: S608
    query = f"SELECT count(*), group_concat(id, '') FROM ({ids})"  # noqa: S608
    found = {}
    for (bucket,) in connection.execute(parts).fetchall():
        count, together = connection.execute(query, (bucket, f"{bucket}g")).fetchone()
        found[bucket] = (count, hashlib.md5(together.encode(), usedforsecurity=False).hexdigest())
    return found


def lengths_in(connection: sqlite3.Connection, bucket: str) -> dict[str, int]:
    """Bytes of the content, by id."""
    query = f"SELECT id, length(CAST(content AS BLOB)) FROM facts WHERE id >= ? AND id < ? AND {_IS_ID}"  # noqa: S608
    return dict(connection.execute(query, (bucket, f"{bucket}g")).fetchall())


def rows_in(connection: sqlite3.Connection, ids: list[str]) -> list[tuple[Any, ...]]:
    """Return the rows as they stand there."""
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
            self._file = file = sqlite3.connect(path, timeout=BUSY_S, isolation_level=None, check_same_thread=False)
            try:
                file.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_ROW)
                # A stranger's text may be no UTF-8: it cannot be encoded again, and so is no fact.
                file.text_factory = lambda data: data.decode(errors="surrogateescape")
                file.execute("PRAGMA trusted_schema = OFF")
                file.execute("PRAGMA cell_size_check = ON")
                # No write-ahead log: a stick that is pulled out has one file, and not two of three.
                file.execute("PRAGMA journal_mode = DELETE")
                file.execute("PRAGMA synchronous = FULL")
                check_or_make(file, path)
                schema = "SELECT type, name, sql FROM sqlite_master ORDER BY type, name"
                # A trigger or a view of somebody else's would run when the file is read or written.
                with closing(sqlite3.connect(":memory:", isolation_level=None)) as ours:
                    make_tables(ours)
                    if file.execute(schema).fetchall() != ours.execute(schema).fetchall():
                        raise sqlite3.DatabaseError("its tables are not those of an archive file")
                # What was put into it would be facts of its own station, on which verdicts rest.
                if file.execute("SELECT 1 FROM state").fetchone() is not None:
                    raise sqlite3.DatabaseError("it is the store of a station")
                # As a whole only now, as that runs what a stranger's tables demand of each row.
                check_whole(file)
            except BaseException:
                self.close()
                raise

    def close(self) -> None:
        self._file.close()

    def buckets(self) -> Buckets:
        with self._troubles():
            return digests(self._file, "facts", _IS_ID)

    def lengths(self, bucket: str) -> dict[str, int]:
        with self._troubles():
            return lengths_in(self._file, bucket)

    def rows(self, ids: list[str]) -> list[tuple[Any, ...]]:
        with self._troubles():
            return rows_in(self._file, ids)

    def add(self, rows: list[tuple[Any, ...]]) -> int:
        """How many were new: they are durable."""
        before = self._file.total_changes
        with self._troubles(), self._file:  # which commits, or rolls back where it fails
            self._file.execute("BEGIN IMMEDIATE")
            self._file.executemany(INSERT, rows)
        return self._file.total_changes - before

    @contextmanager
    def _troubles(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            raise FileTrouble(marked("{file} cannot be used: {why}."), file=self.name, why=str(error)) from error
