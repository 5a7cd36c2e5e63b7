"""Several modules: those connected, with LOCK, checks and one profile; and all ever seen, with the shared archive."""
