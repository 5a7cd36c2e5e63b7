"""Would it have fired? Reads flight logs and recordings, judges them, maps thresholds and proposes them."""
