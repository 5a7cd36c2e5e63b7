"""Thresholds from flight logs: map, lists, proposal."""
