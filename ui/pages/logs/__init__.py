"""Recordings and flight logs in one list: would it have fired, thresholds, map, proposal."""
