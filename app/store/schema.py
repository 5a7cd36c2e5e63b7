"""Schema as a list of migrations.

A step that has been released is never changed; what is new is a step behind it. The number of steps taken is the
file's `user_version`. Times are ISO 8601 in UTC.
"""

from app.store.audit_chain import AUDIT_CHAIN_TABLES
from app.store.guided_schema import GUIDED_TABLES
from app.store.preflight_schema import PREFLIGHT_ADAPTERS, PREFLIGHT_TABLES

APPLICATION_ID = 0x44505353
""" "DPSS": how our file is told from another program's."""

MODULE_STATE_TABLES: tuple[str, ...] = (
    """
    CREATE TABLE module_states (
        module_id INTEGER PRIMARY KEY REFERENCES modules (id),
        at TEXT NOT NULL,
        boot_count INTEGER,
        settings TEXT NOT NULL
    ) STRICT
    """,
    """
    CREATE TABLE streams_left_on (
        adapter TEXT PRIMARY KEY,
        at TEXT NOT NULL
    ) STRICT
    """,
)

SETTLEMENT_TABLES: tuple[str, ...] = (
    """
    CREATE TABLE module_settlements (
        id INTEGER PRIMARY KEY AUTOINCREMENT,
        at TEXT NOT NULL,
        content TEXT NOT NULL
    ) STRICT
    """,
)
"""Whether modules of several stations are the same one, as a person said."""

MIGRATIONS: tuple[tuple[str, ...], ...] = (
    (
        """
        CREATE TABLE modules (
            id INTEGER PRIMARY KEY,
            name TEXT NOT NULL UNIQUE,
            adapter TEXT NOT NULL,
            first_seen_at TEXT NOT NULL,
            last_seen_at TEXT NOT NULL
        ) STRICT
        """,
        """
        CREATE TABLE settings_snapshots (
            id INTEGER PRIMARY KEY,
            module_id INTEGER REFERENCES modules (id),
            port TEXT NOT NULL,
            taken_at TEXT NOT NULL,
            reason TEXT NOT NULL,
            boot_count INTEGER,
            settings TEXT NOT NULL
        ) STRICT
        """,
        """
        CREATE TABLE audit (
            id INTEGER PRIMARY KEY,
            module_id INTEGER REFERENCES modules (id),
            port TEXT NOT NULL,
            origin TEXT NOT NULL,
            at TEXT NOT NULL,
            act TEXT NOT NULL,
            frame TEXT NOT NULL,
            detail TEXT NOT NULL,
            settled_at TEXT,
            outcome TEXT,
            result TEXT
        ) STRICT
        """,
        "CREATE INDEX audit_by_time ON audit (at)",
        """
        CREATE TABLE pending_baud (
            id INTEGER PRIMARY KEY,
            port TEXT NOT NULL,
            adapter TEXT NOT NULL,
            old_rate INTEGER NOT NULL,
            new_rate INTEGER NOT NULL,
            at TEXT NOT NULL,
            settled_at TEXT,
            outcome TEXT
        ) STRICT
        """,
    ),
    PREFLIGHT_TABLES,
    PREFLIGHT_ADAPTERS,
    AUDIT_CHAIN_TABLES,
    MODULE_STATE_TABLES,
    ("ALTER TABLE streams_left_on ADD COLUMN boot_count INTEGER",),
    GUIDED_TABLES,
    SETTLEMENT_TABLES,
)
