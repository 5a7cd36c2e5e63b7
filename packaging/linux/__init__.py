"""What Linux alone needs: the .deb, its files, and what bundles there link to."""
