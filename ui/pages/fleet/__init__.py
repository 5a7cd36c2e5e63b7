"""All connected modules on one board: state, LOCK, checks and one profile for several."""
