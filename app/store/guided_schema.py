"""Schema of the results of guided tests. Rows are only ever added."""

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
