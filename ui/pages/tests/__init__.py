"""Guided tests: what needs a person as one of its parts."""
