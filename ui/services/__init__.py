"""What the pages are given: storage, recordings, the notice of a job."""
