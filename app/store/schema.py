"""The tables of the store and of the archive. A file of a former layout is converted (`app.store.former`).

Times are ISO 8601 in UTC.
"""

import sqlite3
from collections.abc import Callable
from typing import Final, NamedTuple

APPLICATION_ID: Final = 0x44505353
""" "DPSS": how our file is told from another program's."""

_KEPT: Final = "BEGIN SELECT RAISE(ABORT, 'facts are only ever added'); END"
TABLES: Final = (
    """
    CREATE TABLE facts (
        number INTEGER PRIMARY KEY AUTOINCREMENT,
        id TEXT UNIQUE,
        kind TEXT NOT NULL,
        station TEXT,
        made_at TEXT NOT NULL,
        payload TEXT NOT NULL,
        signature TEXT,
        digest TEXT,
        module TEXT,
        link TEXT,
        hash TEXT NOT NULL
    ) STRICT
    """,
    "CREATE INDEX facts_of_kind ON facts (kind, module, number)",
    "CREATE INDEX facts_of_link ON facts (link, kind)",
    "CREATE INDEX facts_in_chain ON facts (hash)",
    "CREATE INDEX facts_to_compare ON facts (id, digest)",
    "CREATE INDEX facts_to_sign ON facts (number) WHERE id IS NULL",
    f"CREATE TRIGGER facts_not_removed BEFORE DELETE ON facts {_KEPT}",
    f"CREATE TRIGGER facts_signed_once BEFORE UPDATE ON facts WHEN OLD.id IS NOT NULL {_KEPT}",
    f"CREATE TRIGGER facts_unchanged BEFORE UPDATE OF number, kind, made_at, payload, module, hash ON facts {_KEPT}",
    "CREATE TABLE state (key TEXT PRIMARY KEY, value TEXT NOT NULL) STRICT",
)


class StoreLayout(NamedTuple):
    """`version`: the file's `user_version`. `convert`: makes `TABLES` from those of a former version, within a
    transaction."""

    version: int
    convert: Callable[[sqlite3.Connection], None]


def check(connection: sqlite3.Connection) -> None:
    """Raises `sqlite3.Error` for a file that is damaged or another program's."""
    tables = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
    application = connection.execute("PRAGMA application_id").fetchone()[0]
    if tables and application != APPLICATION_ID:
        raise sqlite3.DatabaseError("of another program")
    if connection.execute("PRAGMA quick_check(1)").fetchone()[0] != "ok":
        raise sqlite3.DatabaseError("quick_check")


def check_copy(connection: sqlite3.Connection) -> None:
    """An empty one is not good either."""
    check(connection)
    if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
        raise sqlite3.DatabaseError("empty")


def make_tables(connection: sqlite3.Connection) -> None:
    for statement in TABLES:
        connection.execute(statement)
