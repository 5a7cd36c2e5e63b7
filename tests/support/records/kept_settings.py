"""The settings as they were before a write, as a store keeps them."""

import json

from app.store.store import Store


def kept_settings(store: Store) -> list[dict[str, object]]:
    """The newest first."""
    rows = store.database.read("SELECT settings FROM settings_snapshots ORDER BY id DESC")
    return [json.loads(row[0]) for row in rows]
