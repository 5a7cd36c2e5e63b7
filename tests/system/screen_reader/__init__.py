"""Manual check on the accessibility bus."""
