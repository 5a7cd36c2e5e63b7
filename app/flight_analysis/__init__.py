"""Thresholds from flights: when each threshold would have fired first, maps over thresholds, proposals."""
