"""The DPS-S serial protocol: bytes and the time in, bytes and events out. Standard library only."""
