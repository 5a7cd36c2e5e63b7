"""Trigger records of the module."""
