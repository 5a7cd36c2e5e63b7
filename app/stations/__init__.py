"""Who signs records, and whose signatures are trusted."""
