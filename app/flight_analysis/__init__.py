"""Thresholds from flights: first firing by threshold, map over thresholds, proposals."""
