"""What acts on the module at once."""
