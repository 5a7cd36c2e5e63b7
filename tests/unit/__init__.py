"""Tests of app/, in its rooms."""
