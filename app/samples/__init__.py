"""Samples over time: ring buffers and values that hold until the next change."""
