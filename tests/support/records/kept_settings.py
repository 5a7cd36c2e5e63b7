"""Reads the snapshots of settings from a store."""

import json

from app.store.store import Store


def kept_settings(store: Store) -> list[dict[str, object]]:
    """Return the snapshots, newest first."""
    rows = store.database.read("SELECT settings FROM settings_snapshots ORDER BY id DESC")
    return [json.loads(row[0]) for row in rows]
