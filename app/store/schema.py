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


def make_tables(connection: sqlite3.Connection) -> None:
    for statement in TABLES:
        connection.execute(statement)
