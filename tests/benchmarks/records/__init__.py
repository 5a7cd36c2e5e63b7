"""Benchmarks of what is kept of all stations."""
