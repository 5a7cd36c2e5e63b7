"""Benchmarks: how quick, how light and how smooth the program is. See `python -m tests.benchmarks --help`."""
