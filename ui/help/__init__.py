"""Guide, shortcuts, about."""
