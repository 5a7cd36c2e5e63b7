"""The SQLite file: facts, only ever added; and the state, which may change."""
