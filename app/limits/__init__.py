"""What a value may be: what a profile expects, floors that none goes below, what is outside now."""
