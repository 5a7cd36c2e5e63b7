"""The commands that write settings or compare them: set, save, diff."""
