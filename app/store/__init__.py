"""The SQLite file: facts, only ever added, in one chain; and the state, which may change."""
