"""Flights and flight logs made for tests."""
