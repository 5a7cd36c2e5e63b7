"""Flight logs of PX4, ArduPilot and others, read into one form."""
