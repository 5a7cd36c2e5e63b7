"""Tests complete and careless gestures at the window."""
