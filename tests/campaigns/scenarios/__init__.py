"""Stateful, random and hostile scenarios."""
