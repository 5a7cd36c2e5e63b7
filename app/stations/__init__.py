"""Who signs records."""
