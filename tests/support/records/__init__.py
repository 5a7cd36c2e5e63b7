"""Records, recordings and captures made for tests."""
