"""What is run by hand against a screen reader's bus."""
