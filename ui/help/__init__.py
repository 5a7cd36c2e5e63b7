"""Guide, about."""
