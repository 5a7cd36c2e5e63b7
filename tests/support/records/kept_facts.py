"""Reads a store, and alters it as somebody would who wants to change what it says."""

import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from app.store.facts import FactKind, fact_hash
from app.store.store import Store


def kept_settings(store: Store) -> list[dict[str, object]]:
    """Return the snapshots, newest first."""
    return [fact.content["settings"] for fact in reversed(store.facts.select(FactKind.SNAPSHOT))]


def tamper(path: Path, *statements: str) -> None:
    """Execute SQL in the file of a store or an archive without what guards it."""
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        guards = connection.execute("SELECT name FROM sqlite_master WHERE type = 'trigger'").fetchall()
        for statement in (*(f"DROP TRIGGER {name}" for (name,) in guards), *statements):
            connection.execute(statement)


def forge(path: Path, number: int, change: Callable[[str], str]) -> None:
    """Replace the payload of a fact, with a hash that fits it."""
    with closing(sqlite3.connect(path)) as connection:
        query = "SELECT kind, made_at, payload FROM facts WHERE number = ?"
        kind, made_at, payload = connection.execute(query, (number,)).fetchone()
    changed = change(payload)
    assert changed != payload
    tamper(path, f"UPDATE facts SET hash = '{fact_hash(kind, made_at, changed)}' WHERE number = {number}")
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("UPDATE facts SET payload = ? WHERE number = ?", (changed, number))
