"""A module of software, written from the vendor's table: behaviour, physical side, faults, and ways to reach it."""
