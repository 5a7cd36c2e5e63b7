"""Would it have fired? The rules, for one sample after the other or for whole arrays."""
