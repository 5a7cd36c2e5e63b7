"""What the pages are given: storage, recordings, the module's name."""
