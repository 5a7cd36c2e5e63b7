"""Makes flights and flight logs for tests."""
