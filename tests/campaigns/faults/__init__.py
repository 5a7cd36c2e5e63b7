"""Tests every fault of the line in every phase of every procedure."""
