"""Additional port URLs for pyserial: sim://."""
