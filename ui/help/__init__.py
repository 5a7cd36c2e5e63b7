"""Guide, shortcuts, What's This, about."""
