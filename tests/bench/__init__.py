"""Benchmarks of speed, memory and smoothness. See `python -m tests.bench --help`."""
