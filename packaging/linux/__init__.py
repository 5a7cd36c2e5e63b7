"""For Linux: the .deb, its files, and the libraries that bundles link to."""
