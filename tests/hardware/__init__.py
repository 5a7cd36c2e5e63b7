"""Tests of a real module, or of whatever answers at a port: `pytest tests/hardware --port /dev/ttyUSB0`."""
