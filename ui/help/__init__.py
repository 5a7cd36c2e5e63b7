"""Guide, shortcuts, tour, What's This, about."""
