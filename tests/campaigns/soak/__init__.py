"""Endurance: the window on a module whose line goes wrong in every way. See `python -m tests.campaigns.soak --help`."""
