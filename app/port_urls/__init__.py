"""An additional port URL for pyserial: sim://, the simulated module."""
