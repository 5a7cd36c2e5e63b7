"""The window as the tests work it."""
