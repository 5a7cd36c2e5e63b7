"""What the pages are given: storage, recordings, work in the background and what is said of it."""
