"""Schema of trigger records, visits and pre-flight checks."""

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

PREFLIGHT_ADAPTERS: tuple[str, ...] = ("ALTER TABLE preflight_checks ADD COLUMN adapter TEXT",)
"""Modules without a name have a chain of records for each adapter."""
