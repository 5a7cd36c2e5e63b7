"""Schema as a list of migrations.

A step that has been released is never changed; what is new is a step behind it. The number of steps taken is the
file's `user_version`. Times are ISO 8601 in UTC.
"""

from app.store.audit_chain import AUDIT_CHAIN_TABLES

APPLICATION_ID = 0x44505353
""" "DPSS": how our file is told from another program's."""

PREFLIGHT_TABLES: tuple[str, ...] = (
    """
    CREATE TABLE trigger_records (
        id INTEGER PRIMARY KEY,
        module_id INTEGER NOT NULL REFERENCES modules (id),
        place INTEGER NOT NULL,
        raw TEXT NOT NULL,
        first_seen_at TEXT NOT NULL,
        judgement TEXT,
        judged_at TEXT,
        note TEXT NOT NULL DEFAULT '',
        UNIQUE (module_id, place)
    ) STRICT
    """,
    """
    CREATE TABLE visits (
        id INTEGER PRIMARY KEY,
        module_id INTEGER REFERENCES modules (id),
        at TEXT NOT NULL,
        port TEXT NOT NULL,
        boot_count INTEGER,
        slots TEXT NOT NULL,
        is_confirmed INTEGER NOT NULL,
        known INTEGER NOT NULL
    ) STRICT
    """,
    "CREATE INDEX visits_by_module ON visits (module_id, id)",
    """
    CREATE TABLE preflight_checks (
        id INTEGER PRIMARY KEY,
        module_id INTEGER REFERENCES modules (id),
        number INTEGER NOT NULL,
        at TEXT NOT NULL,
        aircraft TEXT NOT NULL,
        who TEXT NOT NULL,
        verdict TEXT NOT NULL,
        is_void INTEGER NOT NULL,
        fingerprint TEXT,
        hash TEXT NOT NULL UNIQUE,
        previous TEXT,
        record TEXT NOT NULL
    ) STRICT
    """,
    "CREATE INDEX preflight_checks_by_module ON preflight_checks (module_id, number)",
    """
    CREATE TABLE measured_values (
        id INTEGER PRIMARY KEY,
        check_id INTEGER NOT NULL REFERENCES preflight_checks (id),
        name TEXT NOT NULL,
        value REAL NOT NULL
    ) STRICT
    """,
    "CREATE INDEX measured_values_by_name ON measured_values (name, check_id)",
)
"""Trigger records, visits and pre-flight checks."""

PREFLIGHT_ADAPTERS: tuple[str, ...] = ("ALTER TABLE preflight_checks ADD COLUMN adapter TEXT",)
"""Modules without a name have a chain of records for each adapter."""

GUIDED_TABLES: tuple[str, ...] = (
    """
    CREATE TABLE guided_tests (
        id INTEGER PRIMARY KEY AUTOINCREMENT,
        module_id INTEGER REFERENCES modules (id),
        adapter TEXT NOT NULL,
        at TEXT NOT NULL,
        who TEXT NOT NULL,
        kind TEXT NOT NULL,
        verdict TEXT NOT NULL,
        is_simulated INTEGER NOT NULL,
        program TEXT NOT NULL,
        measured TEXT NOT NULL
    ) STRICT
    """,
    "CREATE INDEX guided_tests_by_module ON guided_tests (module_id, kind, id)",
    """
    CREATE TRIGGER guided_tests_kept BEFORE DELETE ON guided_tests
    BEGIN SELECT RAISE(ABORT, 'results are only ever added'); END
    """,
    """
    CREATE TRIGGER guided_tests_unchanged BEFORE UPDATE ON guided_tests
    BEGIN SELECT RAISE(ABORT, 'results are only ever added'); END
    """,
)
"""Results of guided tests: rows are only ever added."""

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
    ("ALTER TABLE modules ADD COLUMN said_new_at TEXT",),
)
