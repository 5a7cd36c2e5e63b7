"""Port URLs of our own for pyserial: sim://."""
