"""Guided tests: procedures with the person as one of their parts, and their results kept."""
