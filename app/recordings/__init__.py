"""Session recordings: written while a port is open, listed, read back, and exported."""
