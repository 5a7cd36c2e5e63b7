"""What is known under a module's name: its last reading, what speaks against it, services that are due, labels."""
