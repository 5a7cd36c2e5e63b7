"""Cause of a failed connection, traffic, statistics, support bundle."""
