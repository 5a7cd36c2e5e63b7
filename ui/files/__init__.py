"""Choosing, dropping and saving files."""
