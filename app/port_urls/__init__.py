"""Additional port URLs for pyserial: sim://, and rfc2217:// with a limit of writing."""
