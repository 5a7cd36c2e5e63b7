"""Makes records, recordings and captures for tests."""
