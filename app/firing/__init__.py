"""Would it have fired? Rules, analysis, near misses."""
