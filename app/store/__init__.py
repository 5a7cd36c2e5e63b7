"""The SQLite file: open, check, migrate; modules, snapshots and the audit log in it."""
