"""Plots over time, gauge and small charts."""
