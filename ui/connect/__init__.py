"""Choosing a port and naming a module."""
