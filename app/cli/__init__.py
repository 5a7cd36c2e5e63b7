"""The commands of dps-s, one module each."""
