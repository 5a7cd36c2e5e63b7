"""Additional port URLs for pyserial: sim:// and rfc2217://."""
