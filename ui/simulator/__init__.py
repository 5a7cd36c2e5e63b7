"""The panel of the simulated module."""
