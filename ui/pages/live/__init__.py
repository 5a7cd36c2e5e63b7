"""Tilt, acceleration, light and cell as they come."""
